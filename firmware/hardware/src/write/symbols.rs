//! Symbols of parts, as SVG around their middle.

use crate::Part;

/// A symbol with its terminals.
pub(super) struct Symbol {
    pub svg: &'static str,
    /// Numbers of the pins, where their wire ends, and where its name is.
    pub terminals: &'static [(&'static str, i32, i32, Side)],
    /// Half its height with the names at its ends.
    pub half_height: i32,
}

/// Side of a terminal at which its name is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    /// To the right of a vertical wire.
    End,
}

/// The symbol of a part with more than two terminals, where there is one.
pub(super) fn stacked(part: &Part) -> Option<Symbol> {
    use Side::{End, Left, Right};
    Some(match part.kind.as_str() {
        // The P-channel transistor above the N-channel one.
        "IRF7307" => Symbol {
            svg: "<path d=\"M-44 -36h28M-10 -48v24M-4 -50v28M-4 -45h16v-17M-4 -27h16V27M-4 27h16\
                  M12 0h32M-44 36h34M-10 24v24M-4 22v28M-4 45h16v17\"/><circle cx=\"-13\" cy=\"-36\" r=\"3\"/>\
                  <text x=\"18\" y=\"-32\" class=\"s\">P</text><text x=\"18\" y=\"40\" class=\"s\">N</text>",
            terminals: &[
                ("3", 12, -62, End),
                ("4", -44, -36, Left),
                ("5 to 8", 44, 0, Right),
                ("2", -44, 36, Left),
                ("1", 12, 62, End),
            ],
            half_height: 74,
        },
        "BAS70-04" => Symbol {
            svg: "<path d=\"M0 -44v88M-34 0h34M-10 -24h20M-10 8h20\"/>\
                  <path class=\"f\" d=\"M-9 -8h18L0 -24zM-9 24h18L0 8z\"/>",
            terminals: &[("2", 0, -44, End), ("3", -34, 0, Left), ("1", 0, 44, End)],
            half_height: 52,
        },
        _ => return None,
    })
}

/// The symbol of a part with two terminals, with wires to both sides.
pub(super) fn two_terminal(part: &Part) -> Option<&'static str> {
    Some(match part.kind.as_str() {
        "resistor" => {
            "<path d=\"M-45 0h20M25 0h20\"/><rect x=\"-25\" y=\"-7\" width=\"50\" height=\"14\"/>"
        }
        "ntc" => {
            "<path d=\"M-45 0h20M25 0h20M-20 12h8L16 -14\"/><rect x=\"-25\" y=\"-7\" width=\"50\" height=\"14\"/>"
        }
        "fuse" => "<path d=\"M-45 0h90\"/><rect x=\"-25\" y=\"-7\" width=\"50\" height=\"14\"/>",
        "capacitor" => "<path d=\"M-45 0h41M4 0h41M-4 -12v24M4 -12v24\"/>",
        "capacitor-electrolytic" => {
            "<path d=\"M-45 0h41M6 0h39M-4 -12v24M10 -12q-8 12 0 24M-16 -9h6M-13 -12v6\"/>"
        }
        "jumper" => {
            "<path d=\"M-45 0h29M16 0h29M-12 -2L14 -12\"/><circle cx=\"-14\" cy=\"0\" r=\"3\"/>\
             <circle cx=\"14\" cy=\"0\" r=\"3\"/>"
        }
        "SMAJ7.5A" => {
            "<path d=\"M-45 0h33M12 0h33M-12 -10v20M-12 -10l5 -4M-12 10l-5 4M12 -10v20L-12 0z\"/>"
        }
        _ => return None,
    })
}
