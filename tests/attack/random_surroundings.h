#pragma once
// What is round the part in the random attack: the machine, bodies beside the part, and faces with a name.

#include <string>

#include "tests/attack/dice.h"
#include "tests/attack/random_part.h"

namespace tiltfeed::attack {

/// A machine profile with travels and turns for whatever a job asks, by the words of config/machines.
std::string wide_profile();

/// Bodies beside the part, turned with it; some reach into it. A section of a job.
std::string random_fixtures(Dice& dice, const RandomPart& part);

/// A ball about a place of the part, as the name of the facets in it.
std::string named_ball(Dice& dice, const RandomPart& part);

}  // namespace tiltfeed::attack
