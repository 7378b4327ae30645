// Entries of a tool library as text.

#include "config/description.h"
#include "config/enum_words.h"
#include "config/json_tree.h"
#include "config/tool_import.h"
#include "config/yaml_edit.h"

namespace tiltfeed::config {
namespace {

class ToolText {
 public:
  void add(const char* key, const std::string& text) {
    if (!text.empty()) line(key, quoted_text(text));
  }
  void add(const char* key, double value) {
    if (value != 0.0) line(key, exact_text(tidy(value)));
  }
  void line(const char* key, const std::string& value) {
    text_ += (text_.empty() ? "  - " : "    ") + std::string(key) + ": " + value + "\n";
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string inner(const std::vector<std::pair<const char*, double>>& values) {
  std::string text;
  for (const auto& [key, value] : values)
    if (value != 0.0) text += (text.empty() ? "" : ", ") + std::string(key) + ": " + exact_text(tidy(value));
  return text;
}

std::string entry_text(const ToolEntry& tool) {
  ToolText out;
  out.add("id", tool.id);
  out.add("name", tool.name);
  out.add("vendor", tool.vendor);
  out.add("product", tool.product);
  out.add("number", tool.number);
  if (tool.type) out.line("type", word(kCutterWords, *tool.type));
  out.add("diameter_mm", tool.diameter);
  out.add("corner_radius_mm", tool.corner_radius);
  out.add("flutes", tool.flutes);
  out.add("length_mm", tool.length);
  out.add("cutting_length_mm", tool.cutting_length);
  out.add("shank_diameter_mm", tool.shank_diameter);
  out.add("shank_length_mm", tool.shank_length);
  std::string text = out.text();
  if (!tool.holder.empty()) text += "    holder:\n";
  for (const pathgen::HolderStep& step : tool.holder)
    text += "      - {" +
            inner({{"diameter_mm", step.lower_diameter},
                   {"upper_diameter_mm", step.upper_diameter},
                   {"length_mm", step.length}}) +
            "}\n";
  if (!tool.data.empty()) text += "    cutting_data:\n";
  for (const CuttingData& data : tool.data) {
    const std::string values = inner({{"spindle_rpm", data.spindle_rpm},
                                      {"cut_mm_per_min", data.cut_feed},
                                      {"plunge_mm_per_min", data.plunge_feed}});
    text +=
        "      - {material: " + quoted_text(data.material) + (values.empty() ? "" : ", ") + values + "}\n";
  }
  return text;
}

}  // namespace

std::string tool_library_text(const std::vector<ToolEntry>& tools, const std::string& remark) {
  std::string text = remark.empty() ? "" : "# " + one_line(remark) + "\n";
  text += "tools:\n";
  for (const ToolEntry& tool : tools) text += entry_text(tool);
  return text;
}

}  // namespace tiltfeed::config
