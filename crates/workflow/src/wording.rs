//! Settings in the messages of libraries, as the command line calls them.

/// The words before the name of a setting in messages of libraries. Messages of serde have names in
/// the same quotes, without these words, so they stay as they are.
const BEFORE: &str = "the setting `";

/// A message with the options of the command line in place of the settings.
///
/// Libraries name a setting by the field that holds it. The command line's option is that name with
/// dashes.
///
/// ```
/// use transect_workflow::as_options;
///
/// let message = "the setting `depth_scale` is 1000; unknown field `scale`";
/// assert_eq!(as_options(message), "--depth-scale is 1000; unknown field `scale`");
/// ```
pub fn as_options(message: &str) -> String {
    let mut parts = message.split(BEFORE);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once('`') {
            Some((name, rest)) => {
                text.push_str(&format!("--{}{rest}", name.replace('_', "-")));
            }
            None => text.extend([BEFORE, part]),
        }
    }
    text
}
