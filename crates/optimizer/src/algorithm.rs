//! The optimisers by name, and the settings of each. A new optimiser is one file and one line here.

use serde::{Deserialize, Serialize};

use crate::optimizer::{Optimizer, SettingsError};
use crate::{
    Mpio, MpioSettings, Mslpio, MslpioSettings, Nsga2, Nsga2Settings, Random, RandomSettings, Slpio, SlpioSettings,
};

/// Of each optimiser its key in a scenario file, its type and the type of its settings. The settings have a default,
/// `validate`, `evaluations` and `with_budget`; the optimiser is made from them by `new`.
macro_rules! algorithms {
    ($($(#[$about:meta])+ $key:ident: $optimizer:ident($settings:ident);)+) => {
        /// Which optimiser.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
        #[serde(rename_all = "lowercase")]
        pub enum Algorithm {
            $($(#[$about])+ $optimizer,)+
        }

        impl Algorithm {
            /// All there are.
            pub const ALL: &[Self] = &[$(Self::$optimizer),+];

            /// Its name in a scenario file.
            pub fn key(self) -> &'static str {
                match self { $(Self::$optimizer => stringify!($key)),+ }
            }
        }

        /// Which optimiser, and the settings of each. The settings of the other optimisers have no effect, so that a
        /// scenario can hold them all.
        ///
        /// ```
        /// use optimizer::{Algorithm, Nsga2Settings, OptimizerSettings};
        ///
        /// let settings = OptimizerSettings {
        ///     algorithm: Algorithm::Nsga2,
        ///     nsga2: Nsga2Settings { population: 20, ..Nsga2Settings::default() },
        ///     ..OptimizerSettings::default()
        /// };
        /// let optimizer = settings.build()?;
        /// assert_eq!(optimizer.name(), "NSGA-II");
        ///
        /// // The same number of evaluations for every optimiser: 30 generations of 40 candidates.
        /// assert_eq!(settings.with_budget(40, 30).evaluations(), 1200);
        /// # Ok::<(), optimizer::SettingsError>(())
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct OptimizerSettings {
            /// Which one.
            pub algorithm: Algorithm,
            $($(#[$about])+ pub $key: $settings,)+
        }

        impl Default for OptimizerSettings {
            fn default() -> Self {
                Self { algorithm: Algorithm::Mslpio, $($key: $settings::default()),+ }
            }
        }

        impl OptimizerSettings {
            /// Makes the optimiser that `algorithm` names.
            ///
            /// # Errors
            /// One of its settings is out of range.
            pub fn build(&self) -> Result<Box<dyn Optimizer>, SettingsError> {
                Ok(match self.algorithm { $(Algorithm::$optimizer => Box::new($optimizer::new(self.$key)?)),+ })
            }

            /// How many candidates it evaluates in a solve.
            pub fn evaluations(&self) -> usize {
                match self.algorithm { $(Algorithm::$optimizer => self.$key.evaluations()),+ }
            }

            /// These settings with a budget of `generations` generations of `candidates` candidates for every
            /// optimiser, to compare them on equal terms.
            pub fn with_budget(self, candidates: usize, generations: usize) -> Self {
                Self { algorithm: self.algorithm, $($key: self.$key.with_budget(candidates, generations)),+ }
            }

            /// Whether the settings of every optimiser are in range, also of those that are not in use.
            ///
            /// # Errors
            /// The first optimiser with a setting out of range, and that setting.
            pub fn validate(&self) -> Result<(), (Algorithm, SettingsError)> {
                $(self.$key.validate().map_err(|error| (Algorithm::$optimizer, error))?;)+
                Ok(())
            }
        }
    };
}

algorithms! {
    /// Multi-objective social learning pigeon-inspired optimisation.
    mslpio: Mslpio(MslpioSettings);
    /// Multi-objective pigeon-inspired optimisation.
    mpio: Mpio(MpioSettings);
    /// The non-dominated sorting genetic algorithm II.
    nsga2: Nsga2(Nsga2Settings);
    /// Social learning pigeon-inspired optimisation, of the sum of the objectives.
    slpio: Slpio(SlpioSettings);
    /// Random search, the control.
    random: Random(RandomSettings);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_algorithm_is_built_under_its_key_with_a_budget_that_compares() {
        for &algorithm in Algorithm::ALL {
            let settings = OptimizerSettings { algorithm, ..OptimizerSettings::default() };
            let name = settings.build().expect("in range").name().replace('-', "").to_lowercase();
            assert_eq!(name.replace("ii", "2"), algorithm.key());
            assert!((650..=651).contains(&settings.evaluations()), "{name}");
        }
    }

    #[test]
    fn with_a_budget_everyone_spends_as_much() {
        for &algorithm in Algorithm::ALL {
            let settings = OptimizerSettings { algorithm, ..OptimizerSettings::default() };
            for (candidates, generations) in [(6, 1), (10, 4), (100, 250)] {
                let settings = settings.with_budget(candidates, generations);
                assert_eq!(settings.evaluations(), candidates * generations, "{algorithm:?}");
                assert!(settings.build().is_ok(), "{algorithm:?}");
            }
        }
    }

    #[test]
    fn what_is_out_of_range_is_named_with_whose_it_is() {
        let mut settings = OptimizerSettings::default();
        assert_eq!(settings.validate(), Ok(()));
        settings.nsga2.population = 7;
        let (algorithm, error) = settings.validate().expect_err("odd");
        assert_eq!((algorithm, error.setting, error.value), (Algorithm::Nsga2, "population", 7.0));
        // It is not in use.
        assert!(settings.build().is_ok());
    }
}
