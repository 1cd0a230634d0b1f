//! Wrong use, as one line.

use clap::error::ErrorKind;

/// What clap has to say without its usage screen: message, tips, and where to read on.
pub(super) fn one_line(message: &clap::Error) -> String {
    if message.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return "no command given; umbrage --help lists them".to_owned();
    }
    let text = message.to_string();
    let body = text.split("\nUsage:").next().unwrap_or_default();
    let body = body
        .split("\nFor more information")
        .next()
        .unwrap_or_default();
    let words: Vec<&str> = body.split_whitespace().collect();
    let words = words.join(" ");
    let words = words.strip_prefix("error: ").unwrap_or(&words);
    let words = words.replace(" tip: ", "; ");
    format!("{words}; umbrage --help and umbrage COMMAND --help list what is possible")
}
