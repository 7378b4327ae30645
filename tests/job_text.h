#pragma once
// A job text that is right in every key, for tests to damage.

#include <string>

namespace tiltfeed {

inline const std::string kJobFolder = SOURCE_DIR "/config/jobs/";
/// Need not exist: texts are parsed as if they came from there.
inline const std::string kJobPath = kJobFolder + "t.yaml";

inline const std::string kGoodJob =
    "part: {name: p-1, stl: parts/../p.stl, unit: inch}\n"                         // 1
    "cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}\n"  // 2
    "axis:\n"                                                                      // 3
    "  mode: circle\n"                                                             // 4
    "  sense: inward\n"                                                            // 5
    "  origin_mm: [1, 2, 3]\n"                                                     // 6
    "  t: [0, 2, 0]\n"                                                             // 7
    "  n: [0, 0, -3]\n"                                                            // 8
    "  circle_radius_mm: 50\n"                                                     // 9
    "pattern: {along: y, direction: one_way, side_step_mm: 0.5}\n"                 // 10
    "tolerance_mm: 0.02\n"                                                         // 11
    "allowance_mm: 0.3\n"                                                          // 12
    "clearance_mm: 5\n"                                                            // 13
    "approach_mm: 1\n"                                                             // 14
    "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300, spindle_rpm: 9000}\n"   // 15
    "setup: {part_zero_mm: [1, 2, 3], fixture_rotation_deg: [10, 20, 30]}\n"       // 16
    "machine: ../machines/generic-ac.yaml\n";                                      // 17

}  // namespace tiltfeed
