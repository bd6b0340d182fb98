//! The table of a campaign in a document.

use crate::injection::{Injection, Place};
use crate::outcome::Outcome;

/// A row of the table: a place, and the results of its experiments.
pub type Row<'a> = (Place, &'a [(Injection, Outcome)]);

const BEGIN: &str = "<!-- table of the campaign: begin -->";
const END: &str = "<!-- table of the campaign: end -->";

/// The table in Markdown.
pub fn table(rows: &[Row<'_>]) -> String {
    let mut text = String::from(
        "| place | injections | no effect | small or short | told | **silent and hazardous** | not judged |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for (place, results) in rows {
        let name = match place {
            Place::Ram => "RAM: variables and used stack",
            Place::Code => "flash: vectors, code, constants",
            Place::Registers => "R0 to R15 and flags",
            Place::Instruction => "a skipped instruction",
        };
        text += &format!("| {name} | {} |", results.len());
        for outcome in Outcome::ALL {
            let count = results
                .iter()
                .filter(|(_, other)| *other == outcome)
                .count();
            text += &format!(" {count} |");
        }
        text.push('\n');
    }
    text
}

/// The document with this text between the two comments that enclose the table; `None` if it lacks
/// them.
pub fn replace_table(document: &str, text: &str) -> Option<String> {
    let (before, rest) = document.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n\n{text}\n{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_replaced_between_its_comments_alone() {
        let document = format!("before\n{BEGIN}\nold\n{END}\nafter\n");
        let new = replace_table(&document, "new\n").unwrap();
        assert_eq!(new, format!("before\n{BEGIN}\n\nnew\n\n{END}\nafter\n"));
        assert_eq!(replace_table(&new, "new\n"), Some(new.clone()));
        assert_eq!(replace_table("no table", "new"), None);
    }
}
