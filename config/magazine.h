#pragma once
// The tools that stand in a machine, as its profile lists them.

#include <string>
#include <vector>

#include "config/description.h"
#include "config/section.h"

namespace tiltfeed::config {

struct MagazineTool {
  int number = 0;  ///< the program's T
  std::string id;  ///< of a tool library
};

/// In the profile's order, all numbers different; one tool may stand in several places.
using Magazine = std::vector<MagazineTool>;

/// The key `magazine` of a machine profile; empty where absent.
Magazine read_magazine(const Section& root);
/// Nothing where it is empty.
void describe(const Magazine& magazine, Description& out);

/// The tool that a job asks for.
struct WantedTool {
  std::string id;       ///< empty: it says none
  int number = 0;       ///< of the program, or of the library where the program says none
  bool stated = false;  ///< the number, by the program
};

/// The number under which the magazine has it; where nothing is known of the magazine, the wanted number.
/// A number of 0 that is stated means the tool in the spindle, whatever it is. Errors: kInput with what the
/// magazine has; the message begins with the key of the job that is wrong.
Result<int> number_in(const Magazine& magazine, const std::string& machine, const WantedTool& wanted);

}  // namespace tiltfeed::config
