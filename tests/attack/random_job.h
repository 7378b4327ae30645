#pragma once
// The text of a job for the random attack: every choice that a job file leaves to its writer, from a seed.

#include <string>

#include "tests/attack/dice.h"
#include "tests/attack/random_part.h"

namespace tiltfeed::attack {
using namespace pathgen;

/// A job that begins a line so is planned for the shortest time.
inline constexpr const char* kShortestTime = "# attack: optimise time";

/// `stl` and `machine`: as the job names them.
std::string random_job(Dice& dice, const RandomPart& part, const std::string& name, const std::string& stl,
                       const std::string& machine);

}  // namespace tiltfeed::attack
