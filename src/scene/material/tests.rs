//! Materials as scene files give them.

use super::*;

fn material(text: &str, unit_mm: f64) -> Result<Material, String> {
    let file: MaterialFile = toml::from_str(text).map_err(|e| e.message().to_string())?;
    Material::check(&file, "object.0.material", unit_mm).map_err(|e| e.to_string())
}

#[test]
fn units_and_scale_multiply_the_coefficients() {
    let marble = material("preset = 'marble'\nscale = 2.0", 10.0).expect("marble");
    assert_eq!((marble.name.as_str(), marble.eta), ("Marble", [1.5; 3]));
    assert!((marble.sigma_s_prime[0] - 43.8).abs() < 1e-12);
    assert!((marble.sigma_a[2] - 0.142).abs() < 1e-12);
}

#[test]
fn explicit_keys_win_over_the_preset() {
    let text = "preset = 'Skim Milk'\neta = [0.7, 1.2, 3.8]\nfresnel = 'paper'";
    let milk = material(text, 1.0).expect("milk");
    assert_eq!(milk.name, "Skimmilk, modified");
    assert_eq!((milk.eta, milk.fresnel), ([0.7, 1.2, 3.8], Fresnel::Paper));
    let own = material("sigma_s_prime = 1\nsigma_a = 0", 1.0).expect("custom");
    assert_eq!((own.name.as_str(), own.eta, own.fresnel), ("custom", [ETA; 3], Fresnel::Exact));
}

#[test]
fn names_the_key_at_fault() {
    let cases = [
        (
            "preset = 'marbel'",
            "object.0.material.preset: unknown preset, did you mean `Marble`?; \
             found marbel; expected Apple, Chicken1,",
        ),
        ("sigma_a = 1", "object.0.material.sigma_s_prime: missing"),
        ("sigma_s_prime = 1", "object.0.material.sigma_a: missing"),
        ("preset = 'apple'\neta = 0.4", "object.0.material.eta: out of range; found [0.4"),
        (
            "preset = 'apple'\neta = 4\nfresnel = 'paper'",
            "object.0.material.eta: out of range; found [4, 4, 4]; expected numbers of at most 3.8, or fresnel",
        ),
        ("preset = 'apple'\nscale = 0", "object.0.material.scale: out of range; found 0"),
        ("preset = 'apple'\nsigma_a = -1", "object.0.material.sigma_a: out of range"),
        (
            "sigma_s_prime = [1, 0, 1]\nsigma_a = 0",
            "object.0.material.sigma_s_prime: a channel neither scatters nor absorbs; \
             found 0 for both in channel g",
        ),
        (
            "sigma_s_prime = 1e308\nsigma_a = 1e308",
            "object.0.material.sigma_s_prime: out of range; found 1e308 and 1e308; expected sigma_s_prime + sigma_a a finite",
        ),
        ("sigma_s_prime = 1e300\nsigma_a = 0\nscale = 1e300", "object.0.material.sigma_s_prime: not a finite"),
    ];
    for (text, message) in cases {
        let error = material(text, 1.0).err().unwrap_or_default();
        assert!(error.starts_with(message), "{error}");
    }
}
