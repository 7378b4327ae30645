#pragma once
// A machine profile that is right in every key, for tests to change and to damage.

#include <string>

#include "config/machine_profile.h"
#include "tests/texts/bad_text.h"

namespace tiltfeed {
using namespace config;

/// Need not exist: texts are parsed as if they came from there.
inline const std::string kMachinePath = "shop/m.yaml";

inline const std::string kGoodMachine =
    "name: nutator 5\n"                                                                // 1
    "linear:\n"                                                                        // 2
    "  x: {min_mm: -1, max_mm: 2, velocity_mm_per_min: 3, acceleration_mm_per_s2: 4,"  // 3
    " jerk_mm_per_s3: 23}\n"
    "  y: {min_mm: -5, max_mm: 6, velocity_mm_per_min: 7, acceleration_mm_per_s2: 8}\n"       // 4
    "  z: {min_mm: -9, max_mm: 10, velocity_mm_per_min: 11, acceleration_mm_per_s2: 12}\n"    // 5
    "tilt:\n"                                                                                 // 6
    "  letter: B\n"                                                                           // 7
    "  direction: [0, 3, 4]\n"                                                                // 8
    "  sign: -1\n"                                                                            // 9
    "  zero_deg: 1.5\n"                                                                       // 10
    "  min_deg: -30\n"                                                                        // 11
    "  max_deg: 95\n"                                                                         // 12
    "  velocity_deg_per_min: 13\n"                                                            // 13
    "  acceleration_deg_per_s2: 14\n"                                                         // 14
    "rotary: {letter: C, direction: [0, 0, 2], sign: +1, min_deg: -360, max_deg: 720,\n"      // 15
    "         velocity_deg_per_min: 15, acceleration_deg_per_s2: 16, jerk_deg_per_s3: 24}\n"  // 16
    "table_centre_mm: [17, 18, 19]\n"                                                         // 17
    "pivot_to_gauge_mm: [1.5, -22, -145.4]\n"                                                 // 18
    "program:\n"                                                                              // 19
    "  dialect: grbl\n"                                                                       // 20
    "  linear_decimals: 3\n"                                                                  // 21
    "  rotary_decimals: 5\n"                                                                  // 22
    "  max_line_length: 70\n"                                                                 // 23
    "  line_numbers: true\n"                                                                  // 24
    "  max_inverse_time_per_min: 9999.5\n"                                                    // 25
    "link: {default: \"serial:/dev/ttyACM0\", receive_buffer_bytes: 1024}\n"                  // 26
    "control: {look_ahead_blocks: 40, corner_time_ms: 2.5, blend_rotary: false}\n";           // 27

/// kGoodMachine with one piece replaced.
inline Result<MachineProfile> parse_changed(const std::string& from, const std::string& to) {
  return parse_machine(replaced(kGoodMachine, from, to), kMachinePath);
}

}  // namespace tiltfeed
