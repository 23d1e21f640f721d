//! `train` and `experiment`: bad configurations.

use crate::{check, folder};

#[test]
fn bad_configurations() {
    let folder = folder();
    for (text, parts) in [
        ("seeed = 1\n", &["seeed", "seed"][..]),
        ("environment_steps = -1\n", &["environment_steps", "-1"]),
        ("seed = \"one\"\n", &["seed"]),
        ("seed = \n", &["line 1"]),
        ("[ppo]\nclipp = 0.2\n", &["clipp"]),
    ] {
        std::fs::write(folder.path().join("config.toml"), text).unwrap();
        let outcome = check(folder.path(), "train config.toml --out trained", 2, parts);
        assert!(outcome.stderr.starts_with("error: config.toml"), "{text}{}", outcome.stderr);
        assert_eq!(outcome.stdout, "", "{text}");
    }
    check(
        folder.path(),
        "train nowhere.toml --out trained",
        2,
        &["nowhere.toml", "cannot be read"],
    );
    check(folder.path(), "experiment nowhere.toml", 2, &["nowhere.toml", "cannot be read"]);
    assert!(!folder.path().join("trained").exists());
}
