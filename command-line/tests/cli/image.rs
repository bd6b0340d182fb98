//! `actuator image`.

use bootloader::{ACTUATOR_BOARD, Version};
use predicates::str::contains;
use program_image::signed::{Description, read_key, sign};

use super::Cli;

#[test]
fn an_image_is_shown_and_verified_by_the_key_that_signed_it() {
    let cli = Cli::new();
    cli.actuator("image key own").assert().success();
    let description = Description {
        hardware: ACTUATOR_BOARD,
        version: Version::parse("1.2.3").expect("a version"),
        replaces: Version::parse("2.0.0"),
    };
    let key = read_key(&cli.path("own")).expect("the key");
    cli.write("a.img", sign(&[5; 1000], &description, &key));
    let shown = cli.text("image show a.img");
    for expected in ["1.2.3", "recovery of 2.0.0", "0x5341", "1000 bytes"] {
        assert!(shown.contains(expected), "{shown}");
    }
    assert!(
        cli.text("image verify a.img --key own.pub")
            .contains("signed by this key")
    );
    cli.assert_error(
        "image verify a.img",
        2,
        "a.img: the signature is not of this key",
    );
}

#[test]
fn what_is_no_image_and_no_key_is_refused_and_a_key_is_not_overwritten() {
    let cli = Cli::new();
    cli.write("text", "no image");
    cli.assert_error(
        "image show text",
        2,
        "text: no image, or its header is damaged",
    );
    cli.assert_error("image show nowhere", 1, "nowhere: ");
    cli.assert_error("image verify text --key text", 2, "text: no key");
    cli.assert_error("image sign text --out a.img", 2, "text: ");
    let version = "image sign text --out a.img --version 1.2";
    cli.assert_error(version, 2, "1.2 is no version");
    cli.actuator("image key own").assert().success();
    let own = cli.read("own");
    cli.actuator("image key own")
        .assert()
        .code(1)
        .stderr(contains("own: "));
    assert_eq!(cli.read("own"), own);
}
