//! Keys and what is held with them, as text: `Ctrl+Shift+S`.

use std::fmt;
use std::str::FromStr;

/// A key by its name, as keyboards print it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(&'static str);

#[rustfmt::skip]
const NAMES: [&str; 83] = [
    "A", "B", "C", "D", "E", "F", "G", "H", "I", "J", "K", "L", "M", "N", "O", "P", "Q", "R", "S", "T", "U", "V", "W",
    "X", "Y", "Z", "0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "F1", "F2", "F3", "F4", "F5", "F6", "F7", "F8",
    "F9", "F10", "F11", "F12", "Up", "Down", "Left", "Right", "Home", "End", "PageUp", "PageDown", "Insert", "Delete",
    "Backspace", "Enter", "Tab", "Space", "Escape", "Comma", "Period", "Plus", "Minus", "Equals", "Slash", "Backslash",
    "Semicolon", "Quote", "Backtick", "OpenBracket", "CloseBracket", "Colon", "Pipe", "Questionmark", "F13", "F14",
    "F15", "F16", "Menu",
];

#[rustfmt::skip]
const SIGNS: [(&str, &str); 15] = [
    ("Comma", ","), ("Period", "."), ("Plus", "+"), ("Minus", "-"), ("Equals", "="), ("Slash", "/"), ("Backslash", "\\"),
    ("Semicolon", ";"), ("Quote", "'"), ("Backtick", "`"), ("OpenBracket", "["), ("CloseBracket", "]"), ("Colon", ":"),
    ("Pipe", "|"), ("Questionmark", "?"),
];

impl Key {
    /// In any case of letters.
    pub fn named(name: &str) -> Option<Self> {
        NAMES.iter().find(|known| known.eq_ignore_ascii_case(name)).map(|known| Self(known))
    }

    pub fn name(self) -> &'static str {
        self.0
    }

    /// What is printed on it.
    pub fn shown(self) -> &'static str {
        SIGNS.iter().find(|(name, _)| *name == self.0).map_or(self.0, |(_, sign)| sign)
    }
}

/// A key, and what is held while it is pressed. Ctrl stands for the command key where keyboards have one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Shortcut {
    pub ctrl: bool,
    pub shift: bool,
    pub alt: bool,
    pub key: Key,
}

impl FromStr for Shortcut {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || format!("`{text}` is no shortcut: write it as `Ctrl+Shift+S`");
        let mut parts: Vec<&str> = text.split('+').map(str::trim).collect();
        let key = parts.pop().and_then(Key::named).ok_or_else(refused)?;
        let mut shortcut = Self { ctrl: false, shift: false, alt: false, key };
        for part in parts {
            let held = match part.to_ascii_lowercase().as_str() {
                "ctrl" | "cmd" => &mut shortcut.ctrl,
                "shift" => &mut shortcut.shift,
                "alt" => &mut shortcut.alt,
                _ => return Err(refused()),
            };
            if std::mem::replace(held, true) {
                return Err(refused());
            }
        }
        Ok(shortcut)
    }
}

impl Shortcut {
    /// As menus show it.
    pub fn shown(&self) -> String {
        format!("{}{}", self.held(), self.key.shown())
    }

    fn held(&self) -> String {
        let held = [(self.ctrl, "Ctrl+"), (self.shift, "Shift+"), (self.alt, "Alt+")];
        held.into_iter().filter(|(held, _)| *held).map(|(_, name)| name).collect()
    }
}

/// As files and the user write it: [`FromStr`] reads it.
impl fmt::Display for Shortcut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.held(), self.key.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shortcut_is_read_as_it_is_written() {
        for (text, written) in [
            ("ctrl+shift+s", "Ctrl+Shift+S"),
            ("Alt + Ctrl + f12", "Ctrl+Alt+F12"),
            ("delete", "Delete"),
            ("Cmd+Plus", "Ctrl+Plus"),
        ] {
            let shortcut: Shortcut = text.parse().unwrap();
            assert_eq!(shortcut.to_string(), written);
            assert_eq!(written.parse(), Ok(shortcut));
        }
        let shown = |text: &str| text.parse::<Shortcut>().unwrap().shown();
        assert_eq!(
            (shown("Ctrl+OpenBracket"), shown("Shift+F5")),
            ("Ctrl+[".to_owned(), "Shift+F5".to_owned())
        );
        for broken in ["", "Ctrl+", "Ctrl", "Hyper+S", "Ctrl+Ctrl+S", "S+Ctrl", "Ctrl+SS"] {
            assert!(broken.parse::<Shortcut>().is_err(), "{broken}");
        }
    }
}
