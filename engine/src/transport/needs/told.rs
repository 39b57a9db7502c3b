//! Verdicts in words: for the plan's table, the player's overlay, the certificate.

use super::{Forced, Needs, Saving, Verdict};

impl Needs {
    /// A line for each feature that is not there, and why.
    pub fn left_out(&self) -> impl Iterator<Item = String> + '_ {
        self.verdicts.iter().filter(|verdict| !verdict.is_in).map(|verdict| {
            let Verdict { feature, why, forced, .. } = verdict;
            match forced {
                Some(_) => format!("{}: the project says so, though {why}", feature.name()),
                None => format!("{}: {why}", feature.name()),
            }
        })
    }

    /// The same with what it saves; and what is there because the project says so, with its price.
    pub fn told(&self) -> Vec<String> {
        let saved = |verdict: &&Verdict| !verdict.is_in;
        let saved = self.verdicts.iter().filter(saved).zip(self.left_out()).map(|(verdict, line)| {
            let saves = told(", saves ", &verdict.saving);
            format!("left out: {line}{saves}")
        });
        let forced =
            self.verdicts.iter().filter(|verdict| verdict.forced == Some(Forced::In)).map(|verdict| {
                let price = told(", at the price of ", &verdict.saving);
                format!("forced in: {}, though {}{price}", verdict.feature.name(), verdict.why)
            });
        saved.chain(forced).collect()
    }
}

fn told(before: &str, saving: &Saving) -> String {
    let saving = saving.to_string();
    if saving.is_empty() { saving } else { format!("{before}{saving}") }
}

impl Verdict {
    /// "in", "out", or what the project says instead.
    pub fn mark(&self) -> &'static str {
        match (self.forced, self.is_in) {
            (Some(Forced::In), _) => "forced in",
            (Some(Forced::Out), _) => "forced out",
            (None, true) => "in",
            (None, false) => "out",
        }
    }

    /// What it costs, saves, or would.
    pub fn price(&self) -> String {
        match self.is_in {
            true => told("takes ", &self.saving),
            false => told("saves ", &self.saving),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Feature, Finding};
    use super::*;

    #[test]
    fn what_is_left_out_and_what_is_forced_is_told_with_its_price() {
        let saving = Saving { file_bytes: 2000, ..Saving::default() };
        let finding = |needed, why: &str| Finding { needed, why: why.into(), saving, ..Finding::default() };
        let findings = vec![
            (Feature::Sky, finding(false, "the scene has none")),
            (Feature::Holes, finding(false, "nothing has holes")),
            (Feature::Matrix, finding(true, "a lamp moves")),
            (Feature::LightProbes, finding(true, "a ball reads them")),
        ];
        let says = [(Feature::Holes, Forced::In), (Feature::Matrix, Forced::Out)].into();
        let needs = Needs::of(findings, &says);
        assert_eq!(
            needs.told(),
            [
                "left out: sky: the scene has none, saves 2.0 kB of file",
                "left out: matrix at run time: the project says so, though a lamp moves, saves 2.0 kB of file",
                "forced in: test for holes, though nothing has holes, at the price of 2.0 kB of file",
            ]
        );
        let mark = |feature| needs.verdict(feature).mark();
        let marks = [Feature::LightProbes, Feature::Sky, Feature::Holes, Feature::Matrix].map(mark);
        assert_eq!(marks, ["in", "out", "forced in", "forced out"]);
        assert_eq!(needs.verdict(Feature::LightProbes).price(), "takes 2.0 kB of file");
    }
}
