//! An error with its causes in one line, as the programs print it.

use std::error::Error;

/// Causes after what they caused, less those that a message tells already.
pub fn told(error: &(dyn Error + 'static)) -> String {
    let causes = std::iter::successors(Some(error), |error| (*error).source());
    causes.map(ToString::to_string).fold(String::new(), |told, cause| match told.as_str() {
        "" => cause,
        _ if told.contains(&cause) => told,
        _ => format!("{told}: {cause}"),
    })
}

#[cfg(test)]
mod tests {
    use std::io;

    use engine::scene::SceneError;

    #[test]
    fn a_cause_is_told_once() {
        let source = io::Error::other("disk full");
        let error = SceneError::Io { path: "a.ron".into(), source };
        assert_eq!(super::told(&error), "a.ron: disk full");
        let wrapped = anyhow::Error::new(error).context("scene `a`");
        assert_eq!(super::told(wrapped.as_ref()), "scene `a`: a.ron: disk full");
    }
}
