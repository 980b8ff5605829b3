//! The launcher `cargo xtask` lists the commands of `transect`.

use super::common::Folder;

#[test]
fn the_launcher_lists_every_command_as_the_program_does() {
    let launcher = include_str!("../../../../xtask/src/commands.rs");
    let help = Folder::empty().run("--help").succeeded().stdout;
    let (_, commands) = help.split_once("Commands:\n").unwrap();
    let commands = commands.split("\n\n").next().unwrap();
    // A long line of the help goes on in the next one, which begins with more blanks.
    let commands: Vec<String> = commands
        .replace("\n   ", "   ")
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    let listed = commands.iter().filter(|line| !line.starts_with("help ")).inspect(|line| {
        let (name, about) = line.split_once(' ').unwrap();
        assert!(launcher.contains(&format!("(\"{name}\", \"{about}\")")), "{line}");
    });
    assert_eq!(listed.count(), 19);
}
