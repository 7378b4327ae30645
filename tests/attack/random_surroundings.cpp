#include "tests/attack/random_surroundings.h"

#include "tests/attack/written.h"

namespace tiltfeed::attack {
using namespace pathgen;

std::string wide_profile() {
  std::string text = "name: wide\nlinear:\n";
  for (const char* axis : {"x", "y", "z"})
    text += std::string("  ") + axis +
            ": {min_mm: -9000, max_mm: 9000, velocity_mm_per_min: 20000, acceleration_mm_per_s2: 2000}\n";
  text +=
      "tilt: {letter: A, direction: [1, 0, 0], sign: 1, min_deg: -181, max_deg: 181, velocity_deg_per_min: "
      "7200, "
      "acceleration_deg_per_s2: 600}\n"
      "rotary: {letter: C, direction: [0, 0, 1], sign: -1, min_deg: -360000, max_deg: 360000, "
      "velocity_deg_per_min: 14400, acceleration_deg_per_s2: 1200}\n"
      "pivot_to_gauge_mm: [0, 0, -150]\nprogram: {rotary_decimals: 6}\n";
  return text;
}

std::string random_fixtures(Dice& dice, const RandomPart& part) {
  std::string all = "fixtures:\n";
  const std::size_t count = 1 + dice.below(2);
  for (std::size_t i = 0; i < count; ++i) {
    const Point<Part> at = part.centre + dice.direction() * (part.size * dice.uniform(0.2, 0.9));
    const double size = part.size * dice.spread(0.05, 0.5);
    all += formatted("  - {name: body %zu, on: part, ", i + 1);
    switch (dice.below(3)) {
      case 0:
        all += formatted("shape: box, size_mm: [%.4f, %.4f, %.4f]", size, size * dice.uniform(0.2, 2.0),
                         size * dice.uniform(0.2, 2.0));
        break;
      case 1:
        all += formatted("shape: cylinder, diameter_mm: %.4f, height_mm: %.4f", size,
                         size * dice.uniform(0.2, 3.0));
        break;
      default:
        all += formatted("shape: cone, diameter_mm: %.4f, upper_diameter_mm: %.4f, height_mm: %.4f", size,
                         size * dice.uniform(0.1, 0.9), size * dice.uniform(0.2, 2.0));
    }
    all += formatted(", at_mm: [%.4f, %.4f, %.4f], rotation_deg: [%.3f, %.3f, %.3f]}\n", at.x, at.y, at.z,
                     dice.uniform(-90.0, 90.0), dice.uniform(-90.0, 90.0), dice.uniform(-90.0, 90.0));
  }
  return all;
}

std::string named_ball(Dice& dice, const RandomPart& part) {
  const Point<Part> at = part.facets[dice.below(part.facets.size())][0];
  return formatted("\"ball %.4f %.4f %.4f %.4f\"", at.x, at.y, at.z, part.size * dice.spread(0.03, 0.3));
}

}  // namespace tiltfeed::attack
