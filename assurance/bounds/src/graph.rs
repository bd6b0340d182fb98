//! Longest paths through the control-flow graph of a function.

use std::collections::{BTreeMap, BTreeSet};

use crate::program::Function;
use crate::time::Cost;

/// Nodes by address, with their successors.
type Graph = BTreeMap<u64, Vec<u64>>;

/// A set of nodes that are entered together, and whether they form a loop.
struct Component {
    nodes: BTreeSet<u64>,
    is_loop: bool,
}

/// Headers of all loops of a function, in the order in which [`longest`] asks for their bounds:
/// outer loops first, by address.
pub(crate) fn loop_headers(function: &Function) -> Vec<u64> {
    let mut headers = Vec::new();
    let graph = graph_of(function);
    collect_headers(&graph, &BTreeSet::from([function.address]), &mut headers);
    headers
}

fn graph_of(function: &Function) -> Graph {
    let nodes = function.instructions.iter();
    nodes
        .map(|(address, (_, following))| (*address, following.clone()))
        .collect()
}

fn collect_headers(graph: &Graph, entries: &BTreeSet<u64>, headers: &mut Vec<u64>) {
    let mut loops: Vec<_> = components(graph)
        .into_iter()
        .filter(|component| component.is_loop)
        .collect();
    loops.sort_by_key(|component| component.nodes.first().copied());
    for component in loops {
        let (heads, body) = opened(graph, &component.nodes, entries);
        headers.extend(heads.first());
        collect_headers(&body, &heads, headers);
    }
}

/// Entry nodes of a loop, and its body without the edges back to them.
fn opened(graph: &Graph, nodes: &BTreeSet<u64>, entries: &BTreeSet<u64>) -> (BTreeSet<u64>, Graph) {
    let from_outside = graph
        .iter()
        .filter(|(node, _)| !nodes.contains(node))
        .flat_map(|(_, following)| following)
        .chain(entries)
        .copied();
    let heads: BTreeSet<u64> = from_outside.filter(|node| nodes.contains(node)).collect();
    let body = nodes
        .iter()
        .map(|node| {
            let stays = |to: &&u64| nodes.contains(to) && !heads.contains(to);
            (*node, graph[node].iter().filter(stays).copied().collect())
        })
        .collect();
    (heads, body)
}

/// The cost of the longest path through a function. `cost` is that of an instruction with the
/// functions that it calls, `bound` the maximum number of executions of the header of a loop each
/// time the loop is entered.
pub(crate) fn longest(
    function: &Function,
    cost: &dyn Fn(u64) -> Cost,
    bound: &dyn Fn(u64) -> u64,
) -> Cost {
    let entries = BTreeSet::from([function.address]);
    longest_in(&graph_of(function), &entries, cost, bound)
}

fn longest_in(
    graph: &Graph,
    entries: &BTreeSet<u64>,
    cost: &dyn Fn(u64) -> Cost,
    bound: &dyn Fn(u64) -> u64,
) -> Cost {
    let components = components(graph);
    let mut place = BTreeMap::new();
    for (index, component) in components.iter().enumerate() {
        place.extend(component.nodes.iter().map(|node| (*node, index)));
    }
    // Components come before those that lead to them.
    let mut longest: Vec<Cost> = Vec::with_capacity(components.len());
    for (index, component) in components.iter().enumerate() {
        let own = if component.is_loop {
            let (heads, body) = opened(graph, &component.nodes, entries);
            let header = heads.first().copied().unwrap_or_default();
            // With several entries each of them can be the one that repeats.
            let times = bound(header) * heads.len().max(1) as u64;
            longest_in(&body, &heads, cost, bound) * times
        } else {
            component.nodes.iter().map(|node| cost(*node)).sum()
        };
        let following = component.nodes.iter().flat_map(|node| &graph[node]);
        let behind = following
            .filter_map(|node| place.get(node))
            .filter(|other| **other != index)
            .map(|other| longest[*other])
            .fold(Cost::default(), Cost::max);
        longest.push(own + behind);
    }
    let starts = entries.iter().filter_map(|node| place.get(node));
    starts
        .map(|index| longest[*index])
        .fold(Cost::default(), Cost::max)
}

/// Strongly connected components, each before those that lead to it (R. Tarjan, "Depth-first search
/// and linear graph algorithms", SIAM J. Comput. 1(2), 1972), without recursion.
fn components(graph: &Graph) -> Vec<Component> {
    let mut search = Search::default();
    for node in graph.keys() {
        if !search.index.contains_key(node) {
            search.visit(graph, *node);
        }
    }
    search.found
}

#[derive(Default)]
struct Search {
    index: BTreeMap<u64, usize>,
    lowest: BTreeMap<u64, usize>,
    open: Vec<u64>,
    is_open: BTreeSet<u64>,
    found: Vec<Component>,
}

impl Search {
    fn begin(&mut self, node: u64) {
        let index = self.index.len();
        self.index.insert(node, index);
        self.lowest.insert(node, index);
        self.open.push(node);
        self.is_open.insert(node);
    }

    fn lower(&mut self, node: u64, to: usize) {
        self.lowest
            .entry(node)
            .and_modify(|lowest| *lowest = to.min(*lowest));
    }

    fn visit(&mut self, graph: &Graph, start: u64) {
        self.begin(start);
        let mut path = vec![(start, graph[&start].iter())];
        while let Some((node, following)) = path.last_mut() {
            let node = *node;
            match following.next() {
                Some(next) if !self.index.contains_key(next) => {
                    self.begin(*next);
                    path.push((*next, graph[next].iter()));
                }
                Some(next) if self.is_open.contains(next) => self.lower(node, self.index[next]),
                Some(_) => {}
                None => {
                    path.pop();
                    let lowest = self.lowest[&node];
                    if let Some((before, _)) = path.last() {
                        self.lower(*before, lowest);
                    }
                    if lowest == self.index[&node] {
                        self.close(graph, node);
                    }
                }
            }
        }
    }

    fn close(&mut self, graph: &Graph, root: u64) {
        let start = self.open.iter().rposition(|node| *node == root);
        let nodes: BTreeSet<u64> = self.open.drain(start.unwrap_or_default()..).collect();
        for node in &nodes {
            self.is_open.remove(node);
        }
        let is_loop = nodes.len() > 1 || graph[&root].contains(&root);
        self.found.push(Component { nodes, is_loop });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instruction::{Flow, Instruction};

    /// A function of nodes, each of one instruction and one cycle, with their successors.
    fn function(nodes: &[(u64, &[u64])]) -> Function {
        let instruction = |address| Instruction {
            address,
            size: 2,
            flow: Flow::Next,
            stack: 0,
            cycles: 1,
            lines_16: 1,
            begins_block: 0,
            assigned: Vec::new(),
        };
        Function {
            name: "f".into(),
            address: nodes[0].0,
            instructions: nodes
                .iter()
                .map(|(address, following)| (*address, (instruction(*address), following.to_vec())))
                .collect(),
            calls: Vec::new(),
        }
    }

    fn instructions(function: &Function, bound: &dyn Fn(u64) -> u64) -> u64 {
        let one = |_| Cost {
            instructions: 1,
            ..Cost::default()
        };
        longest(function, &one, bound).instructions
    }

    #[test]
    fn the_longest_branch_counts() {
        let diamond = function(&[
            (0, &[2, 8]),
            (2, &[4]),
            (4, &[6]),
            (6, &[10]),
            (8, &[10]),
            (10, &[]),
        ]);
        assert_eq!(instructions(&diamond, &|_| 0), 5);
        assert!(loop_headers(&diamond).is_empty());
    }

    #[test]
    fn nested_loops_multiply_their_bounds() {
        // 0, then 2 { 4 { 6 } } 8: the inner loop is 4 to 6, the outer one 2 to 6.
        let nested = function(&[(0, &[2]), (2, &[4]), (4, &[6]), (6, &[4, 2, 8]), (8, &[])]);
        assert_eq!(loop_headers(&nested), [2, 4]);
        let bound = |header| if header == 2 { 3 } else { 5 };
        assert_eq!(instructions(&nested, &bound), 1 + 3 * (1 + 5 * 2) + 1);
    }

    #[test]
    fn a_loop_of_one_instruction_and_a_loop_with_two_entries_are_loops() {
        let single = function(&[(0, &[2]), (2, &[2, 4]), (4, &[])]);
        assert_eq!(instructions(&single, &|_| 7), 1 + 7 + 1);
        // 0 enters at 2 and at 4: each entry counts the bound.
        let two = function(&[(0, &[2, 4]), (2, &[4]), (4, &[2, 6]), (6, &[])]);
        assert_eq!(loop_headers(&two).len(), 1);
        assert!(instructions(&two, &|_| 3) > 1 + 3 * 2);
    }
}
