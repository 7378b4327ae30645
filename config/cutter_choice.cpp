// The section cutter of a job: a cutter's form, or a tool of a library.

#include <algorithm>

#include "config/description.h"
#include "config/job_keys.h"
#include "config/key_names.h"

namespace tiltfeed::config {
namespace {

constexpr const char* kFormKeys[] = {"type",      "diameter_mm",       "corner_radius_mm",  "taper_deg",
                                     "length_mm", "cutting_length_mm", "shank_diameter_mm", "shank_length_mm",
                                     "holder"};

/// The nearest of these names, and how many there are.
std::string nearest_of(const std::string& name, const std::vector<std::string>& names) {
  return names.empty()
             ? "; it has none"
             : "; nearest: " + quoted(nearest_key(name, names)) + " of " + std::to_string(names.size());
}

const LibraryTool* find_tool(const Section& section, const std::string& id, const ToolLibrary& library) {
  std::vector<std::string> ids;
  for (const LibraryTool& tool : library.tools) {
    if (tool.id == id) return &tool;
    ids.push_back(tool.id);
  }
  section.complain("id", quoted(id) + " is no tool of " + library.path + nearest_of(id, ids));
  return nullptr;
}

const CuttingData* find_data(const Section& section, const std::string& material, const LibraryTool& tool) {
  std::vector<std::string> materials;
  for (const CuttingData& data : tool.data) {
    if (data.material == material) return &data;
    materials.push_back(data.material);
  }
  section.complain("material", "the tool " + quoted(tool.id) + " has no cutting data for " +
                                   quoted(material) + nearest_of(material, materials));
  return nullptr;
}

}  // namespace

CutterChoice read_cutter(const Section& root, const ToolLibrary* tools) {
  const Section section = root.section(
      "cutter", {"library", "id", "material", "type", "diameter_mm", "corner_radius_mm", "taper_deg",
                 "length_mm", "cutting_length_mm", "shank_diameter_mm", "shank_length_mm", "holder"});
  CutterChoice choice;
  section.text("library", "");
  if (!section.has("library")) {
    choice.id = section.has("id") ? section.name("id") : section.text("id", "");
    section.unused("material", "without library");
    choice.cutter = read_cutter_form(section);
    return choice;
  }
  choice.id = section.name("id");
  choice.material = section.text("material", "");
  for (const char* key : kFormKeys) section.unused(key, "where library and id name the tool");
  section.text("library");
  choice.cutter = {.diameter = 100.0, .length = 500.0, .shank_length = 200.0};  // where nothing is known
  if (tools == nullptr || !section.has("id")) return choice;
  const LibraryTool* tool = find_tool(section, choice.id, *tools);
  if (tool == nullptr) return choice;
  std::string lacks;
  for (const std::string& key : tool->lacks) lacks += (lacks.empty() ? "" : ", ") + key;
  if (!lacks.empty())
    section.complain("id", quoted(tool->id) + " at " + to_string(tools->path, tool->place) + " lacks " +
                               lacks + "; measure the tool and add it there");
  else
    choice.cutter = tool->cutter;
  choice.tool = tool;
  if (!choice.material.empty()) choice.data = find_data(section, choice.material, *tool);
  return choice;
}

}  // namespace tiltfeed::config
