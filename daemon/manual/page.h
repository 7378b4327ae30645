#pragma once
// A page of the manual, and the two forms that it is shown in.

#include <string>
#include <vector>

namespace tiltfeed::daemon {

enum class PartKind {
  kHeading,
  kSubheading,
  kText,
  kItem,    ///< of a list: term and text; without a term a bullet
  kSource,  ///< lines as they are
};

struct Part {
  PartKind kind = PartKind::kText;
  std::string text, term = {};
};

struct Page {
  std::string name;  ///< "tiltfeed-plan"
  int section = 1;   ///< 1 programs, 5 files, 7 the rest
  std::string what;  ///< one line, without a full stop
  std::vector<Part> parts;

  std::string file() const { return name + "." + std::to_string(section); }
};

/// For man: troff with the macros of man(7). Lines have 80 bytes at most where the words allow it, and only
/// ASCII. `date`: YYYY-MM-DD.
std::string man_text(const Page& page, const std::string& date, const std::string& version);
/// For a terminal: 80 columns.
std::string plain_text(const Page& page);

}  // namespace tiltfeed::daemon
