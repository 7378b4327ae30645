// Every kind of bad job text, with the exact place and the remedy that its message must have.

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "config/job.h"
#include "tests/texts/bad_text.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

// Kinds: text, YAML features, keys, types, numbers, ranges, words, rules across fields.
const std::vector<BadText> kBadJobs = {
    {"", "", "1:1", "empty"},
    {"", "# a comment\n", "1:1", "empty"},
    {"", "---\n", "2:1", "expected the keys part, cutter"},
    {"", "part\n", "1:1", "expected the keys part, cutter"},
    {"", "part:x\n", "1:1", "put a blank after each ':'"},
    {"", "- part\n", "1:1", "found a list of 1"},
    {"approach_mm: 1", "approach_mm:\t1", "14:13", "tab character"},
    {"  sense: inward", "\tsense: inward", "5:1", "tab character"},
    {"name: p-1", "name: p\x01", "1:15", "byte 1 is not text"},
    {"name: p-1", "name: p\r1", "1:15", "byte 13 is not text"},
    {"name: p-1", "name: \xFFq", "1:14", "byte 255 is not text"},
    {"clearance_mm: 5", "clearance_mm: &c 5", "13:15", "anchors ('&c') are not supported"},
    {"approach_mm: 1", "approach_mm: *c", "14:14", "anchor is not defined"},
    {"{name: p-1", "&a {name: *a", "1:7", "anchors"},
    {"clearance_mm: 5", "clearance_mm: !!float 5", "13:15", "tags"},
    {"name: p-1", "name: !mine p", "1:14", "tags ('!mine')"},
    {"machine:", "<<: {a: 1}\nmachine:", "17:1", "merge keys"},
    {"machine:", "---\nmachine:", "17:1", "one document per file"},
    {"pattern: {", "[a, b]: 1\npattern: {", "10:1", "cannot be a key"},
    {"pattern: {", "? {a: b}\n: 1\npattern: {", "10:3", "cannot be a key"},
    {"mode: circle", ": circle", "4:3", "a key is missing before the ':'"},
    {"mode: circle", "mode: circle: x", "4:15", "not valid YAML"},
    {"name: p-1", "name: [p", "1:49", "not valid YAML"},
    {"approach_mm: 1", "clearance_mm: 6", "14:1", "duplicate key 'clearance_mm', first given on line 13"},
    {"sense: inward", "mode: line", "5:3", "duplicate key 'mode', first given on line 4"},
    {"type: ball", "type: ball, \"type\": ball", "2:22", "duplicate key 'type'"},
    {"side_step_mm", "side_step_in", "10:41", "nearest known key: side_step_mm (unit: mm)"},
    {"side_step_mm", "side_step", "10:41", "nearest known key: side_step_mm (unit: mm)"},
    {"cut_mm_per_min", "cut_in_per_min", "15:9", "nearest known key: cut_mm_per_min (unit: mm/min)"},
    {"tolerance_mm", "tolerence_mm", "11:1", "nearest known key: tolerance_mm"},
    {"  sense", "  sens", "5:3", "unknown key 'sens' in axis; nearest known key: sense"},
    {"axis:", "axle:", "3:1", "nearest known key: axis"},
    {"machine:", "radius_mm: 5\nmachine:", "17:1", "unknown key 'radius_mm'"},
    {"  mode: circle\n", "", "4:3", "missing key 'axis.mode'"},
    {"  sense: inward\n", "", "4:3", "missing key 'axis.sense'"},
    {"  circle_radius_mm: 50\n", "", "4:3", "missing key 'axis.circle_radius_mm'"},
    {"name: p-1, ", "", "1:7", "missing key 'part.name'"},
    {"clearance_mm: 5\n", "", "1:1", "missing key 'clearance_mm'"},
    {"machine: ../machines/generic-ac.yaml\n", "", "1:1", "missing key 'machine'"},
    {"feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300, spindle_rpm: 9000}", "feeds:", "15:1",
     "expected the keys cut_mm_per_min, plunge_mm_per_min, spindle_rpm, highest_mm_per_min, "
     "lowest_mm_per_min, load_percent, change_percent_per_mm, found nothing"},
    {"spindle_rpm: 9000", "highest_mm_per_min: 0", "15:75", "above 0 and at most 100000"},
    {"spindle_rpm: 9000", "lowest_mm_per_min: 1e6", "15:74", "above 0 and at most 100000"},
    {"spindle_rpm: 9000", "load_percent: 5", "15:69", "at least 10 and at most 100"},
    {"spindle_rpm: 9000", "change_percent_per_mm: -1", "15:78", "at least 0 and at most 1000"},
    {"{along: y, direction: one_way, side_step_mm: 0.5}", "[1]", "10:10", "found a list of 1"},
    {"tolerance_mm: 0.02", "tolerance_mm:", "11:1", "expected a number of mm, found nothing"},
    {"tolerance_mm: 0.02", "tolerance_mm: 0.02\nstock: {axial_mm: 0.1}\npoints: {axis_tolerance_deg: 2}",
     "13:30", "a tool that leans cuts into it"},
    {"tolerance_mm: 0.02", "tolerance_mm: 0.02\nstock: {axial_mm: 0.1}\npoints: {calm_deg: 2}", "13:20",
     "a tool that leans cuts into it"},
    {"tolerance_mm: 0.02", "tolerance_mm: ~", "11:1", "expected a number of mm, found nothing"},
    {"tolerance_mm: 0.02", "tolerance_mm: [0.02]", "11:15", "found a list of 1"},
    {"tolerance_mm: 0.02", "tolerance_mm: {a: 1}", "11:15", "found a map"},
    {"tolerance_mm: 0.02", "tolerance_mm: fine", "11:15", "expected a number of mm, found 'fine'"},
    {"tolerance_mm: 0.02", "tolerance_mm: \"0.02\"", "11:15", "remove the quotes"},
    {"tolerance_mm: 0.02", "tolerance_mm: 0,02", "11:15", "write decimals with a point"},
    {"tolerance_mm: 0.02", "tolerance_mm: 0.02 mm", "11:15", "the key states the unit"},
    {"tolerance_mm: 0.02", "tolerance_mm: 0x1", "11:15", "expected a number of mm"},
    {"tolerance_mm: 0.02", "tolerance_mm: .nan", "11:15", "it must be finite"},
    {"tolerance_mm: 0.02", "tolerance_mm: nan", "11:15", "it must be finite"},
    {"tolerance_mm: 0.02", "tolerance_mm: -.inf", "11:15", "it must be finite"},
    {"tolerance_mm: 0.02", "tolerance_mm: inf", "11:15", "it must be finite"},
    {"clearance_mm: 5", "clearance_mm: 1e400", "13:15", "does not fit"},
    {"clearance_mm: 5", "clearance_mm: 0777", "13:15", "without the leading zero"},
    {"clearance_mm: 5", "clearance_mm: +05.5", "13:15", "without the leading zero"},
    {"clearance_mm: 5", "clearance_mm: --5", "13:15", "expected a number of mm"},
    {"clearance_mm: 5", "clearance_mm: ++5", "13:15", "expected a number of mm"},
    {"clearance_mm: 5", "clearance_mm: 0", "13:15", "'0' is out of range; expected a number of mm above 0"},
    {"clearance_mm: 5", "clearance_mm: -5", "13:15", "above 0 and at most 1000"},
    {"clearance_mm: 5", "clearance_mm: 1000.1", "13:15", "above 0 and at most 1000"},
    {"tolerance_mm: 0.02", "tolerance_mm: 0.00009", "11:15", "at least 0.0001 and at most 1"},
    {"tolerance_mm: 0.02", "tolerance_mm: 0.00009", "11:15",
     "32-bit numbers, up to 0.00003 mm off at a metre"},
    {"tolerance_mm: 0.02", "tolerance_mm: 1.1", "11:15", "at least 0.0001 and at most 1"},
    {"allowance_mm: 0.3", "allowance_mm: -0.1", "12:15", "at least 0 and at most 50"},
    {"allowance_mm: 0.3", "allowance_mm: 50.1", "12:15", "at least 0 and at most 50"},
    {"approach_mm: 1", "approach_mm: 0", "14:14", "above 0"},
    {"side_step_mm: 0.5", "side_step_mm: 0", "10:55", "above 0 and at most 1000"},
    {"side_step_mm: 0.5", "side_step_mm: 1001", "10:55", "above 0 and at most 1000"},
    {"diameter_mm: 6", "diameter_mm: 0", "2:35", "above 0 and at most 500"},
    {"30]}", "30], tilt_max_deg: 0}", "16:84", "above 0"},
    {"30]}", "30], tilt_max_deg: 181}", "16:84", "at most 180"},
    {"circle_radius_mm: 50", "circle_radius_mm: -1", "9:21", "above 0"},
    {"cut_mm_per_min: 1000", "cut_mm_per_min: 0", "15:25", "expected a number of mm/min above 0"},
    {"plunge_mm_per_min: 300", "plunge_mm_per_min: 1e6", "15:50", "at most 100000"},
    {"spindle_rpm: 9000", "spindle_rpm: -1", "15:68", "at least 0 and at most 200000"},
    {"part_zero_mm: [1, 2, 3]", "part_zero_mm: [1, 2]", "16:23", "[x, y, z], found a list of 2"},
    {"part_zero_mm: [1, 2, 3]", "part_zero_mm: [1, 2, 3, 4]", "16:23", "found a list of 4"},
    {"part_zero_mm: [1, 2, 3]", "part_zero_mm: [1,5, 2, 3]", "16:23", "decimal commas?"},
    {"part_zero_mm: [1, 2, 3]", "part_zero_mm: 7", "16:23", "[x, y, z], found '7'"},
    {"part_zero_mm: [1, 2, 3]", "part_zero_mm: [1, b, 3]", "16:27", "found 'b'"},
    {"part_zero_mm: [1, 2, 3]", "part_zero_mm: [1, 2, 1e5]", "16:30", "at most 10000"},
    {"[10, 20, 30]", "[10, 361, 30]", "16:61", "expected a number of degrees at least -360"},
    {"mode: circle", "mode: torus", "4:9",
     "expected one of fixed, point, line, circle, free, indexed, found 'torus'"},
    {"sense: inward", "sense: in", "5:10", "expected one of outward, inward, found 'in'"},
    {"type: ball", "type: bull", "2:16", "expected one of ball, bull_nose, flat, taper_ball, found 'bull'"},
    {"along: y", "along: Y", "10:18", "expected one of x, y, found 'Y'"},
    {"direction: one_way", "direction: [zigzag]", "10:32", "expected one of one_way, zigzag"},
    {"unit: inch", "unit: cm", "1:46", "expected mm, inch, m or"},
    {"unit: inch", "unit: 0", "1:46", "out of range"},
    {"unit: inch", "unit: -1", "1:46", "out of range"},
    {"unit: inch", "unit: 2.5cm", "1:46", "expected a number"},
    {"name: p-1", "name: p(1)", "1:14", "found 'p(1)'"},
    {"name: p-1", "name: p\xC3\xA4", "1:14", "A-Z a-z 0-9"},
    {"name: p-1", "name: \"\"", "1:14", "expected a text"},
    {"name: p-1", "name: abcdefghijklmnopqrstuvwxyzabcdefghijklmno", "1:14", "1 to 40"},
    {"name: p-1", "name: [p]", "1:14", "expected a text, found a list of 1"},
    {"machine: ../machines/generic-ac.yaml", "machine: \"../machines/generic-ac.yaml\n\n", "17:10",
     "is a quote left open?"},
    {"stl: parts/../p.stl", "stl: \"a\\nb\"", "1:24", "expected one line of text"},
    {"mode: circle", "mode: line", "9:21", "not used in the mode line, only in circle; remove it"},
    {"mode: circle", "mode: fixed", "5:10", "not used in the mode fixed"},
    {"t: [0, 2, 0]", "t: [0, 0, 0]", "7:6", "zero vector"},
    {"t: [0, 2, 0]", "t: [0, .nan, 0]", "7:10", "finite"},
    {"n: [0, 0, -3]", "n: [0, 3, -3]", "8:6", "t and n are 45"},
    {"n: [0, 0, -3]", "n: [0, 0.0001, -3]", "8:6", "expected 90 within 0.00001 rad"},
    {"n: [0, 0, -3]", "n: [0, 1, 0]", "8:6", "t and n are 0 degrees apart"},
    {"  t: [0, 2, 0]\n  n: [0, 0, -3]\n", "  t: [0, 2, 1]\n", "7:6", "degrees apart"},
    {"shank_length_mm: 30", "shank_length_mm: 101", "2:71", "101 mm is over length_mm, 100 mm"},
    {"shank_length_mm: 30", "shank_length_mm: 2.9", "2:71",
     "below the height of the cutter's rounded end, 3 mm"},
    {"approach_mm: 1", "approach_mm: 5.1", "14:14", "5.1 mm is over clearance_mm, 5 mm"},
    {"diameter_mm: 6", "diameter_mm: 0.04", "11:15", "not below the cutter's smallest radius, 0.02 mm"},
};

// Of kOptionsJob. Cutter, holder, pattern, containment, the rest; then words with their ranges.
const std::vector<BadText> kBadOptions = {
    {"corner_radius_mm: 2", "corner_radius_mm: 0", "5:21", "above 0"},
    {"corner_radius_mm: 2", "corner_radius_mm: 5", "5:21", "5 mm is not below the cutter's radius, 5 mm"},
    {"  corner_radius_mm: 2\n", "", "3:3", "missing key 'cutter.corner_radius_mm'"},
    {"type: bull_nose", "type: flat", "5:21", "not used by the type flat, only by bull_nose; remove it"},
    {"type: bull_nose", "type: taper_ball", "5:21", "not used by the type taper_ball"},
    {"  length_mm", "  taper_deg: 3\n  length_mm", "6:14",
     "not used by the type bull_nose, only by taper_ball"},
    {"bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2", "taper_ball\n  diameter_mm: 10", "3:3",
     "missing key 'cutter.taper_deg'"},
    {"bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2", "taper_ball\n  diameter_mm: 10\n  taper_deg: 0",
     "5:14", "degrees above 0 and below 60"},
    {"bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2", "taper_ball\n  diameter_mm: 10\n  taper_deg: 60",
     "5:14", "degrees above 0 and below 60"},
    {"diameter_mm: 10\n  corner_radius_mm: 2", "diameter_mm: 10\n  corner_radius_mm: 2.5\n  taper: 1", "6:3",
     "nearest known key: taper_deg"},
    {"bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2\n  length_mm: 100\n  cutting_length_mm: 20\n"
     "  shank_diameter_mm: 8\n  shank_length_mm: 40",
     "taper_ball\n  diameter_mm: 10\n  taper_deg: 59\n  length_mm: 900\n  shank_length_mm: 400", "5:14",
     "mm wide at the top of the cutting part; expected at most 500"},
    {"cutting_length_mm: 20", "cutting_length_mm: 1.9", "7:22",
     "below the height of the cutter's rounded end, 2 mm"},
    {"cutting_length_mm: 20", "cutting_length_mm: 41", "7:22", "41 mm is over shank_length_mm, 40 mm"},
    {"cutting_length_mm: 20", "cutting_length_mm: 40", "8:22", "there is no shank; give cutting_length_mm"},
    {"  cutting_length_mm: 20\n", "", "7:22", "there is no shank"},
    {"shank_diameter_mm: 8", "shank_diameter_mm: 501", "8:22", "at most 500"},
    {"holder: [{diameter_mm: 20", "holder: [{diameter_mm: 0", "10:26",
     "cutter.holder[1].diameter_mm: '0' is out"},
    {"upper_diameter_mm: 50, length_mm: 40", "upper_diameter_mm: 50", "10:46",
     "missing key 'cutter.holder[2].length_mm'"},
    {"upper_diameter_mm: 50", "top_mm: 50", "10:64", "in cutter.holder[2]; nearest known key:"},
    {"[{diameter_mm: 20, length_mm: 30}, {diameter_mm: 30, upper_diameter_mm: 50, length_mm: 40}]", "[]",
     "10:11", "cutter.holder: expected a list of 1 to 100 maps, found a list of 0"},
    {"[{diameter_mm: 20, length_mm: 30}, {diameter_mm: 30, upper_diameter_mm: 50, length_mm: 40}]",
     "{diameter_mm: 20, length_mm: 30}", "10:11", "expected a list of 1 to 100 maps, found a map"},
    {"holder: [{diameter_mm: 20, length_mm: 30}", "holder: [20", "10:12",
     "cutter.holder[1]: expected the keys"},
    {"kind: split", "kind: zigzag", "13:9",
     "expected one of raster, z_level, split, contour, spiral, rough, pencil"},
    {"kind: split", "kind: z_level", "14:10",
     "along: not used by the kind z_level, only by raster, split, rough"},
    {"kind: split\n  along: y", "kind: spiral", "14:14",
     "angle_deg: not used by the kind spiral, only by raster"},
    {"kind: split", "kind: raster", "20:17",
     "step_down_mm: not used by the kind raster, only by z_level, split"},
    {"kind: split", "kind: rough", "19:15", "scallop_mm: not used by the kind rough"},
    {"  step_down_mm: 0.7\n", "", "13:3", "missing key 'pattern.step_down_mm'"},
    {"  scallop_mm: 0.004\n", "", "13:3", "missing key 'pattern.scallop_mm'"},
    {"scallop\n  side_step_mm: 0.5\n  scallop_mm: 0.004", "flat", "13:3",
     "missing key 'pattern.side_step_mm'"},
    {"measure: scallop", "measure: surface", "19:15",
     "not used with measure surface, only with scallop and ridge"},
    {"measure: scallop", "measure: ridge", "17:12", "ridge is for the kind raster; expected flat"},
    {"measure: scallop", "measure: chord", "17:12",
     "expected one of flat, surface, scallop, ridge, found 'chord'"},
    {"scallop_mm: 0.004", "scallop_mm: 2", "19:15", "2 mm is not below the cutter's smallest radius, 2 mm"},
    {"angle_deg: 30", "angle_deg: 181", "15:14", "at least -180 and at most 180"},
    {"milling: conventional", "milling: up", "21:12", "expected one of climb, conventional, found 'up'"},
    {"split_slope_deg: 60", "split_slope_deg: 90", "22:20", "above 0 and below 90"},
    {"theta_deg: [-180, 90]", "theta_deg: [90, 90]", "24:14", "from 90 to 90 is empty; expected [low, high]"},
    {"theta_deg: [-180, 90]", "theta_deg: [91, 90]", "24:14", "the interval from 91 to 90 is empty"},
    {"theta_deg: [-180, 90]", "theta_deg: [-181, 90]", "24:15", "degrees at least -180 and at most 180"},
    {"theta_deg: [-180, 90]", "theta_deg: 90", "24:14", "expected a list of two numbers, found '90'"},
    {"theta_deg: [-180, 90]", "theta_deg: [1, 2, 3]", "24:14", "found a list of 3"},
    {"phi_deg: [-45, 90]", "phi_deg: [-45, 91]", "25:18", "degrees at least -90 and at most 90"},
    {"rho_mm: [5, 80]", "rho_mm: [-1, 80]", "26:12", "mm at least 0"},
    {"rho_mm: [5, 80]", "z_mm: [5, 80]", "26:9",
     "z_mm: not used in the mode point, whose coordinates are theta_deg, phi_deg, rho_mm; remove it"},
    {"mode: point", "mode: line", "25:12",
     "phi_deg: not used in the mode line, whose coordinates are x_mm, theta"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [90, 0]]", "27:13",
     "3 to 1000 corners [u, v], found a list of 2"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [90], [0, 45]]", "27:22", "boundary[2]: expected a list of two"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [90, 0], [0, 91]]", "27:35",
     "boundary[3]: '91' is out of range"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [90, 0], [0, b]]", "27:35",
     "boundary[3]: expected a number, found"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [90, 0], [90, 0], [0, 45]]", "27:31",
     "the same corner as number 2"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [90, 0], [0, 45], [0, 0]]", "27:40", "closes by itself"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [0.1, 0.1], [0.3, 0.3]]", "27:14", "lie on one line"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [9, 0], [5, 0], [0, 45]]", "27:22", "turns back on itself"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [9, 9], [9, 0], [0, 9]]", "27:14",
     "the edge from corner 1 to 2 crosses or touches the edge from corner 3 to 4"},
    {"[[0, 0], [90, 0], [0, 45]]", "[[0, 0], [9, 0], [5, 5], [4, 0], [0, 9]]", "27:14", "crosses or touches"},
    {"radial_mm: 0.1", "radial_mm: -0.1", "28:20", "at least 0 and at most 50"},
    {"axial_mm: 0.2", "axial_mm: 51", "28:35", "at least 0 and at most 50"},
    {"max_distance_mm: 3", "max_distance_mm: 0.0009", "29:27",
     "0.0009 is too fine; expected 0 (no limit) or at"},
    {"max_angle_deg: 5", "max_angle_deg: 91", "29:45", "at most 90"},
    {"smoothing_mm: 0.6", "smoothing_mm: -1", "29:62", "at least 0"},
    {"smoothing_mm: 0.6", "axis_tolerance_deg: 10.1", "29:68", "at most 10"},
    {"smoothing_mm: 0.6", "axis_tolerance_deg: 2", "29:68", "a cutter that leans touches elsewhere"},
    {"smoothing_mm: 0.6", "axis_tolerance_deg: -1", "29:68", "at least 0"},
    {"smoothing_mm: 0.6", "calm_deg: 30.1", "29:58", "at most 30"},
    {"smoothing_mm: 0.6", "calm_deg: 2", "29:58", "unless it is a ball"},
    {"reaction: retract", "reaction: stop", "31:40",
     "expected one of trim, retract, tilt, report, found 'stop'"},
    {"shank: {", "collet: {", "31:3", "unknown key 'collet' in guards; nearest known key: "},
    {"clearance_mm: 2, ", "clearance_mm: 101, ", "32:26",
     "guards.holder.clearance_mm: '101' is out of range"},
    {"  holder: [{diameter_mm: 20, length_mm: 30}, {diameter_mm: 30, upper_diameter_mm: 50, length_mm: "
     "40}]\n",
     "", "31:11", "guards.holder: there is no holder to guard; give its steps in cutter.holder"},
    {"diameter_mm: 10", "diameter_mm: \"10,5\"", "4:16",
     "remove the quotes; that is a decimal comma, write decimals with a point: 10.5"},
    {"join_distance_mm: 4", "join_distance_mm: -1", "33:27", "at least 0 and at most 1000"},
    {"lead_radius_mm: 1.5", "lead_radius_mm: 101", "33:46", "at most 100"},
    {"lead_radius_mm: 1.5", "rounds: 1001", "33:38", "1000"},
    {"lead_radius_mm: 1.5", "rounds: 2.5", "33:38", "whole number"},
    {"diameter_mm: 10\n  corner_radius_mm: 2", "diameter_mm: 10\n  corner_radius_mm: 0.01", "1:1",
     "smallest radius"},
};

TEST(JobErrors, EveryKindOfBadInputHasItsPlace) {
  for (const BadText& bad : kBadJobs)
    expect_bad(parse_job(replaced(kGoodJob, bad.from, bad.to), kJobPath), kJobPath, bad);
  for (const BadText& bad : kBadOptions)
    expect_bad(parse_job(replaced(kOptionsJob, bad.from, bad.to), kJobPath), kJobPath, bad);
}

TEST(JobErrors, TheFirstProblemInReadingOrderWins) {
  const std::string two = replaced(replaced(kGoodJob, "  sense:", "  sense_x:"), "type: ball", "type: drill");
  const Result<Job> job = parse_job(two, kJobPath);
  ASSERT_FALSE(job.has_value());
  EXPECT_EQ(job.error().message.substr(0, kJobPath.size() + 6), kJobPath + ":2:16:");
}

TEST(JobErrors, AllProblemsOfAFileAreTold) {
  std::string bad = replaced(kGoodJob, "type: ball", "type: drill");
  bad = replaced(bad, "  sense:", "  sense_x:");
  bad = replaced(bad, "tolerance_mm: 0.02", "tolerance_mm: 0,02");
  bad = replaced(bad, "length_mm: 100", "length_mm: 1,5");
  const Result<Job> job = parse_job(bad, kJobPath);
  ASSERT_FALSE(job.has_value());
  for (const char* part : {"2:16: cutter.type", "sense_x", "found '0,02'",
                           "write decimals with a point: 0.02", "found '5' for a key; a decimal comma"})
    EXPECT_NE(job.error().message.find(part), std::string::npos) << part << " in\n" << job.error().message;
  const Result<Job> empty = parse_job("part: {name: p, stl: p.stl}\n", kJobPath);
  ASSERT_FALSE(empty.has_value());
  EXPECT_NE(empty.error().message.find("missing key 'cutter'"), std::string::npos);
  EXPECT_NE(empty.error().message.find("missing key 'machine'"), std::string::npos);
}

/// A wrong value brings no second error of another that is compared with it or depends on it.
TEST(JobErrors, AWrongValueIsToldOnce) {
  const std::pair<const char*, const char*> kWrong[] = {
      {"mode: circle", "mode: circel"},        {"type: ball", "type: bal"},
      {"diameter_mm: 6", "diameter_mm: -6"},   {"diameter_mm: 6", "diameter_mm: 600"},
      {"along: y", "kind: rowz, along: y"},    {"shank_length_mm: 30", "shank_length_mm: 3000"},
      {"length_mm: 100", "length_mm: \"8,5\""}};
  for (const auto& [from, to] : kWrong) {
    const Result<Job> job = parse_job(replaced(kGoodJob, from, to), kJobPath);
    ASSERT_FALSE(job.has_value()) << to;
    EXPECT_EQ(job.error().message.find('\n'), std::string::npos) << job.error().message;
  }
}

/// A machine of fewer rotary axes: the modes that it serves, and the key where it does not.
TEST(JobErrors, FewerAxesThanTheModeNeeds) {
  const std::string plain = "setup: {part_zero_mm: [1, 2, 3]}";
  const auto told = [&](const std::string& mode, const std::string& directions, const std::string& machine) {
    std::string text = replaced(kGoodJob, "generic-ac", machine);
    text = replaced(text, "setup: {part_zero_mm: [1, 2, 3], fixture_rotation_deg: [10, 20, 30]}", plain);
    text = replaced(text, "  t: [0, 2, 0]\n  n: [0, 0, -3]\n", directions);
    if (mode != "circle") text = replaced(text, "  circle_radius_mm: 50\n", "");
    if (mode == "fixed") text = replaced(text, "  sense: inward\n", "");
    const Result<Job> job = parse_job(replaced(text, "mode: circle", "mode: " + mode), kJobPath);
    return job ? std::string() : job.error().message;
  };
  const std::string along_y = "  t: [0, 1, 0]\n  n: [0, 0, 1]\n",
                    along_x = "  t: [1, 0, 0]\n  n: [0, 0, 1]\n", down = "  t: [1, 0, 0]\n  n: [0, 0, -1]\n";
  EXPECT_EQ(told("fixed", along_y, "mill-3x"), "");
  EXPECT_NE(told("fixed", down, "mill-3x"), "");
  EXPECT_EQ(told("line", along_y, "mill-4x-head-b"), "");
  EXPECT_EQ(told("line", along_x, "mill-4x-table-a"), "");
  for (const char* mode : {"line", "point", "circle"})
    EXPECT_NE(told(mode, along_y, "mill-3x").find(kJobPath + ":4:9: axis.mode: tool axis"), std::string::npos)
        << mode << told(mode, along_y, "mill-3x");
  EXPECT_NE(told("line", along_x, "mill-4x-head-b").find("it has B alone"), std::string::npos);
  EXPECT_NE(told("point", along_y, "mill-4x-head-b").find("axis.mode: "), std::string::npos);

  // These choose their directions: a machine that does not turn every way would end them at their first move.
  const auto any_way = [&](const std::string& mode, const std::string& machine) {
    std::string text = replaced(kGoodJob, "generic-ac", machine);
    const std::size_t from = text.find("axis:"), to = text.find("pattern:");
    const std::string planes = mode == "free" ? ", plane_normals: [[1, 0, 0]]" : "";
    text.replace(from, to - from, "axis: {mode: " + mode + planes + "}\n");
    text = replaced(text, "along: y, ", "");
    const Result<Job> job = parse_job(text, kJobPath);
    return job ? std::string() : job.error().message;
  };
  for (const char* mode : {"free", "indexed"}) {
    EXPECT_EQ(any_way(mode, "generic-ac").find("axis.mode"), std::string::npos)
        << any_way(mode, "generic-ac");
    EXPECT_NE(
        any_way(mode, "mill-3x").find("axis.mode: this mode turns the tool every way, and mill-3x has no"),
        std::string::npos)
        << any_way(mode, "mill-3x");
    EXPECT_NE(any_way(mode, "mill-4x-head-b").find("has the rotary axis B alone"), std::string::npos)
        << any_way(mode, "mill-4x-head-b");
  }
}

TEST(JobErrors, SizeIsCapped) {
  std::string large = kGoodJob + "# " + std::string((1u << 20) - kGoodJob.size() - 2, 'x');
  ASSERT_EQ(large.size(), 1u << 20);
  EXPECT_TRUE(parse_job(large, kJobPath).has_value());
  EXPECT_FALSE(parse_job(large + "x", kJobPath).has_value());
}

TEST(JobErrors, HostileNestingIsRefusedQuickly) {
  for (const std::string piece : {"[", "{", "{a: ", "- ", "? ", "[a, ", "\"", "'"}) {
    std::string text = "part: ";
    while (text.size() < (1u << 20) - 8) text += piece;
    const Result<Job> job = parse_job(text, kJobPath);
    ASSERT_FALSE(job.has_value()) << piece;
    EXPECT_EQ(job.error().message.substr(0, kJobPath.size() + 1), kJobPath + ":") << piece;
    EXPECT_LT(job.error().message.size(), 1000u);
  }
}

TEST(JobErrors, WindowsLineEndsAndByteOrderMarkAreAccepted) {
  std::string text = "\xEF\xBB\xBF";
  for (const char letter : kGoodJob) text += letter == '\n' ? std::string("\r\n") : std::string(1, letter);
  const Result<Job> job = parse_job(text, kJobPath);
  ASSERT_TRUE(job.has_value()) << job.error().message;
  EXPECT_EQ(job->plan.name, "p-1");
}

}  // namespace
}  // namespace tiltfeed
