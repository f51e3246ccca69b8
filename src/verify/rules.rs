//! The rules as data: what each asks for, and the limits that it measures against.
//!
//! What depends on the machine (stops, rates, bridges, heat) is in its profile and not here.

use serde::Serialize;

use super::report::Rule;
use super::{
    astray, coverage, depth, doubled, fill, flow, layers, program, registration, rings, settings, tally, turning,
};
use crate::overhang::{FREE_RIM_MM, FREE_SIDE_MM, LEDGE_MM};
use crate::planning::balance;

/// A rule, what it asks for, and its limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RuleStatement {
    /// The rule.
    pub rule: Rule,
    /// What must hold, in one sentence.
    pub holds: &'static str,
    /// The numbers that are the same for every machine.
    pub limits: &'static [RuleLimit],
}

/// One limit of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RuleLimit {
    /// What is limited, with its unit; a `share` is relative.
    pub name: &'static str,
    /// The most that is let pass; the least where the name begins with `least`.
    pub value: f64,
}

const fn limit(name: &'static str, value: f64) -> RuleLimit {
    RuleLimit { name, value }
}

const fn rule(rule: Rule, holds: &'static str, limits: &'static [RuleLimit]) -> RuleStatement {
    RuleStatement { rule, holds, limits }
}

/// All rules, in the order of [`Rule`].
pub const RULES: [RuleStatement; 23] = [
    rule(Rule::Syntax, "Every line is understood.", &[]),
    rule(Rule::Reading, "The machine's firmware reads every line as it is read here.", &[]),
    rule(Rule::Command, "Every command is known, and changes nothing that later lines rely on.", &[]),
    rule(
        Rule::Setting,
        "Accelerations, speeds, pressure advance and firmware retraction stay within the profile's range.",
        &[
            limit("times_the_profile", settings::TIMES),
            limit("acceleration_mm_per_s2", settings::QUICK),
            limit("least_share_of_the_profile", settings::SHARE),
        ],
    ),
    rule(Rule::AxisLimit, "No axis is sent beyond its stops.", &[]),
    rule(
        Rule::AxisRate,
        "No axis is sent faster than its limit, or implausibly slowly.",
        &[
            limit("least_mm_per_s", program::SLOWEST_MM_PER_S),
            limit("least_share_of_the_turning_rate", program::SLOWEST_TURN),
        ],
    ),
    rule(Rule::TurnWhileExtruding, "The table does not turn while filament is extruded.", &[]),
    rule(
        Rule::Pose,
        "Each print is made at the plan's pose.",
        &[limit("axis_deg", astray::POSE_DEG), limit("up_chord", astray::UPRIGHT)],
    ),
    rule(
        Rule::OutsidePart,
        "Filament is printed only inside the part that is being printed.",
        &[limit("line_edge_mm", registration::MOST_OUT_MM), limit("all_walls_mm", registration::MOST_OFFSET_MM)],
    ),
    rule(
        Rule::InAir,
        "Filament is printed on or against something.",
        &[
            limit("turn_over_air_mm", rings::TURNED_MM),
            limit("ring_over_air_mm", rings::LONGEST_MM),
            limit("ledge_mm", LEDGE_MM),
            limit("ledge_side_mm", FREE_SIDE_MM),
            limit("ledge_rim_mm", FREE_RIM_MM),
        ],
    ),
    rule(
        Rule::HeadCollision,
        "The head keeps clear of the table and of everything printed.",
        &[limit("travel_depth_mm", depth::DEEPEST_MM)],
    ),
    rule(
        Rule::TurnCollision,
        "The head keeps clear while table or head turns.",
        &[limit("least_clearance_mm", turning::ROOM_MM)],
    ),
    rule(
        Rule::Filament,
        "The filament extruded is the filament sliced.",
        &[limit("print_mm", tally::FILAMENT_SLACK_MM), limit("print_share", tally::FILAMENT_SLACK_SHARE)],
    ),
    rule(
        Rule::Flow,
        "Each line uses the filament that its width and height need.",
        &[
            limit("line_share", flow::ONE_LINE),
            limit("role_share", flow::ONE_ROLE),
            limit("print_share", flow::MOST_OFF[0]),
            limit("print_share_without_widths", flow::MOST_OFF[1]),
            limit("doubled_mm", doubled::MOST_MM),
            limit("doubled_infill_mm", doubled::SPARSE_MM),
        ],
    ),
    rule(
        Rule::Fill,
        "Surfaces are full, walls are whole, infill does not stop, and no more is printed than fits.",
        &[
            limit("least_share_of_a_window", fill::LEAST[0]),
            limit("least_share_of_a_surface", fill::LEAST[1]),
            limit("least_share_over_air", fill::OVER_AIR),
            limit("share_of_one_layer", fill::MOST[0]),
            limit("share_of_two_layers", fill::MOST[1]),
            limit("share_of_three_layers", fill::MOST[2]),
            limit("share_of_more_layers", fill::MOST[3]),
            limit("share_of_round_threads", fill::MOST_OF_THREADS),
            limit("share_of_a_top", fill::MOST_ON_TOP),
            limit("slit_mm", fill::SLIT_MM),
            limit("slit_layers", fill::SLIT_LAYERS as f64),
        ],
    ),
    rule(Rule::Heat, "Nothing is extruded cold or heated too far, and all heaters are off at the end.", &[]),
    rule(
        Rule::LayerHeight,
        "Layers follow each other at the height of their lines.",
        &[limit("height_mm", layers::HEIGHT_MM)],
    ),
    rule(
        Rule::Registration,
        "Each print lies where its part is, and its outline has a wall.",
        &[
            limit("shift_mm", registration::MOST_MM),
            limit("wall_inside_mm", registration::MOST_IN_MM),
            limit("bare_outline_mm", coverage::MOST_BARE_MM),
        ],
    ),
    rule(Rule::Complete, "Every layer of every part is in the file, and so is the profile's end code.", &[]),
    rule(
        Rule::Retract,
        "Retracted filament is primed again before printing continues.",
        &[
            limit("one_prime_mm", tally::RETRACT_SLACK_MM),
            limit("all_primes_share", tally::MOST_STRAYED),
            limit("least_share_of_the_retraction_at_turns", tally::LEAST_PULLED),
        ],
    ),
    rule(Rule::UnknownPosition, "Nothing moves before the machine's position is known.", &[]),
    rule(Rule::Sequence, "The prints come in the plan's order, each once.", &[]),
    rule(
        Rule::Standing,
        "The print neither falls over nor comes off at any tilt.",
        &[limit("least_times_its_weight", balance::FALLS)],
    ),
];
