#include "config/tool_library.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "config/cutter_keys.h"
#include "config/description.h"
#include "config/key_ranges.h"
#include "config/section.h"

namespace tiltfeed::config {
namespace {

constexpr Range kSpeed = above(0.0, 10'000.0);     // m/min
constexpr Range kSpindle = above(0.0, 200'000.0);  // 1/min
constexpr Range kTooth = above(0.0, 100.0);        // mm
constexpr std::size_t kMostMaterials = 100;
constexpr double kMmInMetre = 1000.0;

/// Speed and feed, stated as such or by the edge. `diameter`: 0 where it is not known.
CuttingData read_data(const Section& section, double diameter, int flutes) {
  CuttingData data;
  data.material = section.text("material");
  if (const auto speed = section.optional_number("cutting_speed_m_per_min", kSpeed)) {
    // The edge's speed at the full diameter, rounded down to whole turns.
    if (diameter > 0.0)
      data.spindle_rpm =
          std::max(1.0, std::floor(kMmInMetre * *speed / (std::numbers::pi * diameter) + 1e-9));
    section.unused("spindle_rpm", "beside cutting_speed_m_per_min");
  } else {
    data.spindle_rpm = section.optional_number("spindle_rpm", kSpindle).value_or(0.0);
  }
  if (data.spindle_rpm > kSpindle.max)
    section.complain("cutting_speed_m_per_min", "that is " + exact_text(data.spindle_rpm) +
                                                    " 1/min at the tool's diameter, " + exact_text(diameter) +
                                                    " mm; expected at most " + exact_text(kSpindle.max));
  if (const auto tooth = section.optional_number("feed_per_tooth_mm", kTooth)) {
    if (flutes == 0)
      section.complain("feed_per_tooth_mm",
                       "the tool's flutes are not stated; add flutes, or write cut_mm_per_min");
    if (data.spindle_rpm == 0.0 && (diameter > 0.0 || !section.has("cutting_speed_m_per_min")))
      section.complain(
          "feed_per_tooth_mm",
          "no speed is stated; add spindle_rpm or cutting_speed_m_per_min, or write cut_mm_per_min");
    data.cut_feed = tidy(*tooth * flutes * data.spindle_rpm);
    section.unused("cut_mm_per_min", "beside feed_per_tooth_mm");
    if (data.cut_feed > kCuttingFeed.max)
      section.complain("feed_per_tooth_mm", "that is a feed of " + exact_text(data.cut_feed) +
                                                " mm/min; expected at most " + exact_text(kCuttingFeed.max));
  } else {
    data.cut_feed = section.optional_number("cut_mm_per_min", kCuttingFeed).value_or(0.0);
  }
  const auto of_teeth = [&](const char* key) {
    const double value = section.optional_number(key, kTooth).value_or(0.0);
    if (value > 0.0 && flutes == 0) section.complain(key, "the tool's flutes are not stated; add flutes");
    return value;
  };
  data.highest_tooth = of_teeth("highest_feed_per_tooth_mm");
  data.largest_chip = of_teeth("largest_chip_mm");
  data.plunge_feed = section.optional_number("plunge_mm_per_min", kCuttingFeed).value_or(0.0);
  return data;
}

LibraryTool read_tool(const Section& section) {
  LibraryTool tool;
  tool.id = section.name("id");
  tool.name = section.text("name", "");
  tool.vendor = section.text("vendor", "");
  tool.product = section.text("product", "");
  tool.number = section.integer("number", 0, kHighestToolNumber, 0);
  tool.flutes = section.integer("flutes", 0, kMostFlutes, 0);
  tool.cutter = read_cutter_form(section);
  const double diameter = section.has("diameter_mm") ? tool.cutter.diameter : 0.0;
  for (const Section& one :
       section.list("cutting_data",
                    {"material", "cutting_speed_m_per_min", "spindle_rpm", "feed_per_tooth_mm",
                     "cut_mm_per_min", "plunge_mm_per_min", "highest_feed_per_tooth_mm", "largest_chip_mm"},
                    kMostMaterials)) {
    const CuttingData data = read_data(one, diameter, tool.flutes);
    if (std::any_of(tool.data.begin(), tool.data.end(),
                    [&](const CuttingData& other) { return other.material == data.material; }))
      one.complain("material", quoted(data.material) + " is there already; each material has one entry");
    tool.data.push_back(data);
  }
  return tool;
}

/// Hands the keys "tools[3].length_mm" that are missing to their tools; an id must be there.
void share_out(const std::vector<std::string>& missing, const std::vector<Section>& sections,
               std::vector<LibraryTool>& tools) {
  for (const std::string& key : missing) {
    const std::size_t open = key.find('['), close = key.find("].");
    if (open == key.npos || close == key.npos) continue;
    const std::size_t index = std::stoul(key.substr(open + 1)) - 1;
    const std::string name = key.substr(close + 2);
    if (name == "id" || name.starts_with("cutting_data"))
      sections[index].complain(name == "id" ? "id" : "cutting_data", "missing key " + quoted(name));
    else
      tools[index].lacks.push_back(name);
  }
}

/// Of a file that is something else nothing is told: who named it may not be who may read it.
tl::unexpected<Error> no_library(const std::string& path) {
  return fail(Code::kInput, path + ": is no tool library; expected a list of tools (tools:)");
}

/// What cannot be read as a tree is meant as one: a line begins with the key tools.
bool names_tools(const std::string& text) {
  return text.starts_with("tools:") || text.find("\ntools:") != text.npos;
}

}  // namespace

Result<ToolLibrary> parse_tool_library(const std::string& text, const std::string& path) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return names_tools(text) ? Result<ToolLibrary>(tl::unexpected(tree.error())) : no_library(path);
  const auto list = std::find_if(tree->keys.begin(), tree->keys.end(),
                                 [](const YamlKey& key) { return key.text == "tools"; });
  if (list == tree->keys.end()) return no_library(path);
  Complaint complaint(path);
  const Section root(*tree, "", {"tools"}, complaint);
  ToolLibrary library{path, {}};
  const std::vector<Section> sections =
      root.list("tools",
                {"id", "name", "vendor", "product", "number", "type", "diameter_mm", "corner_radius_mm",
                 "taper_deg", "flutes", "length_mm", "cutting_length_mm", "shank_diameter_mm",
                 "shank_length_mm", "holder", "cutting_data"},
                kMostLibraryTools);
  std::map<std::string, int> lines;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    LibraryTool tool = read_tool(sections[i]);
    tool.place = tree->items[static_cast<std::size_t>(list - tree->keys.begin())].items[i].place;
    const auto [other, fresh] = lines.emplace(tool.id, tool.place.line);
    if (!fresh && sections[i].has("id"))
      sections[i].complain("id", config::quoted(tool.id) + " is that of the tool at line " +
                                     std::to_string(other->second) + ", too; each tool has an id of its own");
    library.tools.push_back(std::move(tool));
  }
  share_out(complaint.take_missing(), sections, library.tools);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  return library;
}

Result<ToolLibrary> load_tool_library(const std::string& path) {
  const Result<std::string> text = read_config_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_tool_library(*text, path);
}

}  // namespace tiltfeed::config
