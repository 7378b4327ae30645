#include "config/magazine.h"

#include "config/key_ranges.h"

#include <algorithm>

namespace tiltfeed::config {
namespace {

constexpr std::size_t kMostTools = 1000;  // of the largest magazines
constexpr std::size_t kMostShown = 12;    // of them in a message

std::string contents(const Magazine& magazine) {
  std::string text;
  for (std::size_t i = 0; i < std::min(magazine.size(), kMostShown); ++i)
    text += (i == 0 ? "T" : ", T") + std::to_string(magazine[i].number) + " " + magazine[i].id;
  if (magazine.size() > kMostShown) text += " and " + std::to_string(magazine.size() - kMostShown) + " more";
  return text;
}

std::string remedy(const std::string& machine, const Magazine& magazine) {
  return ", which has " + contents(magazine) + "; load it and add it to `magazine` in " + machine +
         ", or take another tool";
}

}  // namespace

Magazine read_magazine(const Section& root) {
  Magazine magazine;
  const std::vector<Section> items = root.list("magazine", {"number", "id"}, kMostTools);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const MagazineTool tool{items[i].integer("number", 1, kHighestToolNumber), items[i].name("id")};
    const auto same = std::find_if(magazine.begin(), magazine.end(),
                                   [&](const MagazineTool& other) { return other.number == tool.number; });
    if (same != magazine.end() && items[i].has("number"))
      items[i].complain("number", std::to_string(tool.number) + " is that of " + config::quoted(same->id) +
                                      " too; each tool has a number of its own");
    magazine.push_back(tool);
  }
  return magazine;
}

void describe(const Magazine& magazine, Description& out) {
  for (std::size_t i = 0; i < magazine.size(); ++i)
    out.add("magazine[" + std::to_string(i + 1) + "]",
            "T" + std::to_string(magazine[i].number) + " " + magazine[i].id);
}

Result<int> number_in(const Magazine& magazine, const std::string& machine, const WantedTool& wanted) {
  if (magazine.empty() || (wanted.stated && wanted.number == 0)) return wanted.number;
  const auto holds = [&](const MagazineTool& tool) { return tool.number == wanted.number; };
  const auto is = [&](const MagazineTool& tool) { return tool.id == wanted.id; };
  if (wanted.id.empty()) {
    if (wanted.number == 0 || std::any_of(magazine.begin(), magazine.end(), holds)) return wanted.number;
    return fail(Code::kInput, "program.tool: T" + std::to_string(wanted.number) +
                                  " is not in the machine's magazine" + remedy(machine, magazine));
  }
  const auto found = std::find_if(magazine.begin(), magazine.end(), is);
  if (found == magazine.end())
    return fail(Code::kInput, "cutter.id: " + quoted(wanted.id) + " is not in the machine's magazine" +
                                  remedy(machine, magazine));
  if (!wanted.stated) return found->number;
  if (std::any_of(magazine.begin(), magazine.end(),
                  [&](const MagazineTool& tool) { return holds(tool) && is(tool); }))
    return wanted.number;
  return fail(Code::kInput, "program.tool: T" + std::to_string(wanted.number) + " is not " +
                                quoted(wanted.id) + " in the machine's magazine, where that is T" +
                                std::to_string(found->number) + "; write " + std::to_string(found->number) +
                                " or leave the key out");
}

}  // namespace tiltfeed::config
