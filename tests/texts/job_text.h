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

/// The same with every option that kGoodJob leaves at its default; the holder reaches 10 mm over the gauge
/// line.
inline const std::string kOptionsJob =
    "part: {name: p-1, stl: p.stl}\n"  // 1
    "cutter:\n"                        // 2
    "  type: bull_nose\n"              // 3
    "  diameter_mm: 10\n"              // 4
    "  corner_radius_mm: 2\n"          // 5
    "  length_mm: 100\n"               // 6
    "  cutting_length_mm: 20\n"        // 7
    "  shank_diameter_mm: 8\n"         // 8
    "  shank_length_mm: 40\n"          // 9
    "  holder: [{diameter_mm: 20, length_mm: 30}, {diameter_mm: 30, upper_diameter_mm: 50, length_mm: "
    "40}]\n"                                                               // 10
    "axis: {mode: point, sense: outward}\n"                                // 11
    "pattern:\n"                                                           // 12
    "  kind: split\n"                                                      // 13
    "  along: y\n"                                                         // 14
    "  angle_deg: 30\n"                                                    // 15
    "  direction: one_way\n"                                               // 16
    "  measure: scallop\n"                                                 // 17
    "  side_step_mm: 0.5\n"                                                // 18
    "  scallop_mm: 0.004\n"                                                // 19
    "  step_down_mm: 0.7\n"                                                // 20
    "  milling: conventional\n"                                            // 21
    "  split_slope_deg: 60\n"                                              // 22
    "containment:\n"                                                       // 23
    "  theta_deg: [-180, 90]\n"                                            // 24
    "  phi_deg: [-45, 90]\n"                                               // 25
    "  rho_mm: [5, 80]\n"                                                  // 26
    "  boundary: [[0, 0], [90, 0], [0, 45]]\n"                             // 27
    "stock: {radial_mm: 0.1, axial_mm: 0.2}\n"                             // 28
    "points: {max_distance_mm: 3, max_angle_deg: 5, smoothing_mm: 0.6}\n"  // 29
    "guards:\n"                                                            // 30
    "  shank: {clearance_mm: 0.5, reaction: retract}\n"                    // 31
    "  holder: {clearance_mm: 2, reaction: report}\n"                      // 32
    "links: {join_distance_mm: 4, lead_radius_mm: 1.5}\n"                  // 33
    "clearance_mm: 5\n"                                                    // 34
    "approach_mm: 1\n"                                                     // 35
    "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300}\n"              // 36
    "setup: {part_zero_mm: [1, 2, 3]}\n"                                   // 37
    "machine: ../machines/generic-ac.yaml\n";                              // 38

}  // namespace tiltfeed
