#pragma once
// A part for the random attack: a formula part, a shape made up from the seed, or a model file when there are
// any; scaled, perhaps only a piece of it, perhaps damaged.

#include <string>
#include <vector>

#include "pathgen/mesh/stl.h"
#include "tests/attack/dice.h"

namespace tiltfeed::attack {
using namespace pathgen;

using Soup = std::vector<std::array<Point<Part>, 3>>;

struct RandomPart {
  Soup facets;         ///< mm, as an STL file can hold them
  std::string story;   ///< what it is and what was done to it
  double size = 0.0;   ///< diagonal of its box, mm
  Point<Part> centre;  ///< of its box
};

/// `models`: STL files to choose from besides the formula parts.
RandomPart random_part(Dice& dice, const std::vector<std::string>& models);

}  // namespace tiltfeed::attack
