//! An optimisation problem of one's own, solved by every optimiser of this crate: a two-bar truss, as light as possible
//! and as stiff as possible, whose bars must bear the load. `cargo run --release -p optimizer --example 1_own_problem`

use optimizer::indicators::{hypervolume, rows};
use optimizer::selection::nearest_to_ideal;
use optimizer::{Algorithm, Bounds, Candidates, Evaluations, OptimizerSettings, Problem, stream};

/// Two bars of the same section hold a load at height `height_m` above two supports that are 2 m apart. The two
/// dimensions are the section of a bar in cm2 and the height in m.
struct Truss {
    bounds: [Bounds; 2],
}

/// The load, kN, the greatest stress of the steel, kN/cm2, its elasticity, kN/cm2, and its density, kg/m per cm2.
const LOAD_KN: f64 = 200.0;
const STRESS_MAX_KNPCM2: f64 = 20.0;
const ELASTICITY_KNPCM2: f64 = 21_000.0;
const DENSITY_KGPM_PER_CM2: f64 = 0.785;

impl Problem for Truss {
    fn bounds(&self) -> &[Bounds] {
        &self.bounds
    }

    fn objectives(&self) -> usize {
        2
    }

    /// A whole generation in one call: one column for each dimension, one for each objective, one for the violation.
    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        let (sections, heights) = (candidates.coordinate(0), candidates.coordinate(1));
        let ([mass_kg, deflection_mm], violation) = evaluations.objectives_and_violation();
        for (i, (section_cm2, height_m)) in sections.iter().zip(heights).enumerate() {
            let truss = Performance::of(*section_cm2, *height_m);
            (mass_kg[i], deflection_mm[i]) = (truss.mass_kg, truss.deflection_mm);
            // 0 is feasible; what is too much counts, in the unit of the constraint.
            violation[i] = (truss.stress_knpcm2 - STRESS_MAX_KNPCM2).max(0.0);
        }
    }
}

/// What a truss weighs and how it bears the load.
struct Performance {
    mass_kg: f64,
    deflection_mm: f64,
    stress_knpcm2: f64,
}

impl Performance {
    fn of(section_cm2: f64, height_m: f64) -> Self {
        let bar_m = (1.0 + height_m * height_m).sqrt();
        let stress_knpcm2 = 0.5 * LOAD_KN * bar_m / height_m / section_cm2;
        Self {
            mass_kg: 2.0 * bar_m * section_cm2 * DENSITY_KGPM_PER_CM2,
            deflection_mm: 1e3 * stress_knpcm2 / ELASTICITY_KNPCM2 * bar_m * bar_m / height_m,
            stress_knpcm2,
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut problem = Truss { bounds: [Bounds::new(2.0, 40.0), Bounds::new(0.3, 3.0)] };
    println!("optimizer   front   hypervolume   section, cm2   height, m   mass, kg   deflection, mm");
    for &algorithm in Algorithm::ALL {
        // Equal terms: 50 generations of 40 candidates for each.
        let settings = OptimizerSettings { algorithm, ..OptimizerSettings::default() }.with_budget(40, 50);
        let mut optimizer = settings.build()?;
        let front = optimizer.minimise(&mut problem, &mut stream(1, 0, 0))?;

        // How much of the box below (100 kg, 5 mm) the front dominates. SL-PIO minimises the sum of the objectives: its
        // front has one column.
        let dominated = if front.objectives() == 2 {
            format!("{:.1}", hypervolume(&rows(&front), &[100.0, 5.0])?)
        } else {
            "-".to_owned()
        };
        let best = nearest_to_ideal(&front);
        let (section_cm2, height_m) = (front.position(best, 0), front.position(best, 1));
        let Performance { mass_kg, deflection_mm, .. } = Performance::of(section_cm2, height_m);
        let (name, members) = (algorithm.key(), front.len());
        println!(
            "{name:<9}   {members:>5}   {dominated:>11}   {section_cm2:>12.1}   {height_m:>9.2}   {mass_kg:>8.1}   \
             {deflection_mm:>14.2}"
        );
    }
    Ok(())
}
