// Tool bits and libraries of FreeCAD's CAM workbench: JSON, sizes as texts with their unit.

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>

#include "config/json_tree.h"
#include "config/tool_readers.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

namespace fs = std::filesystem;

struct LengthUnit {
  std::string_view word;
  double mm;
};
constexpr std::array<LengthUnit, 9> kLengthUnits{{{"mm", 1.0},
                                                  {"in", 25.4},
                                                  {"\"", 25.4},
                                                  {"inch", 25.4},
                                                  {"cm", 10.0},
                                                  {"m", 1000.0},
                                                  {"um", 0.001},
                                                  {"\xc2\xb5m", 0.001},
                                                  {"ft", 304.8}}};
constexpr std::size_t kMostBits = 10'000;

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// "6.0000 mm", "1/4 in": mm; nothing where it is none.
std::optional<double> length_of(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  auto [at, code] = std::from_chars(text.data(), end, value);
  if (code != std::errc()) return std::nullopt;
  if (at != end && *at == '/') {
    double below = 0.0;
    const auto [stop, fault] = std::from_chars(at + 1, end, below);
    if (fault != std::errc() || below == 0.0) return std::nullopt;
    value /= below, at = stop;
  }
  const std::string unit = lower(one_line(std::string(at, end)));
  const auto found = std::find_if(kLengthUnits.begin(), kLengthUnits.end(),
                                  [&](const LengthUnit& known) { return known.word == unit; });
  if (found == kLengthUnits.end() || !std::isfinite(value * found->mm)) return std::nullopt;
  return value * found->mm;
}

std::optional<pathgen::CutterType> type_of(const std::string& shape) {
  if (shape == "endmill") return pathgen::CutterType::kFlat;
  if (shape == "ballend") return pathgen::CutterType::kBall;
  if (shape == "bullnose") return pathgen::CutterType::kBullNose;
  if (shape == "taperedballnose") return pathgen::CutterType::kTaperBall;
  return std::nullopt;
}

/// "ballend" of "ballend.fcstd"; a shape of one's own has its type beside it.
std::string shape_of(const JsonNode& root) {
  const std::string file = lower(fs::path(root.text_at("shape")).stem().string());
  const std::string type = lower(root.text_at("shape-type"));
  return type_of(file) || type.empty() ? file : type;
}

class Bit {
 public:
  Bit(const JsonNode& root, const std::string& path) : root_(root), path_(path) {}

  Result<ToolEntry> read(std::vector<std::string>& notes) {
    const JsonNode* parameter = root_.find("parameter");
    if (parameter == nullptr || parameter->kind != JsonKind::kMap)
      return fail(Code::kInput, path_ + ": no tool bit: expected a map at \"parameter\"");
    tool_.name = root_.text_at("name");
    if (tool_.name.empty()) tool_.name = fs::path(path_).stem().string();
    root_.find("version");
    const std::string shape = shape_of(root_);
    tool_.type = type_of(shape);
    if (!tool_.type) {
      notes.push_back(config::quoted(tool_.name) + ": left out: " + config::quoted(shape) +
                      " is no form of a cutter here");
      return ToolEntry{};
    }
    for (const auto& [key, value] :
         {std::pair{"Diameter", &tool_.diameter}, std::pair{"CuttingEdgeHeight", &tool_.cutting_length},
          std::pair{"ShankDiameter", &tool_.shank_diameter}})
      if (auto taken = take(*parameter, key, *value); !taken) return tl::unexpected(taken.error());
    if (*tool_.type == pathgen::CutterType::kBullNose)
      for (const char* key : {"CornerRadius", "FlatRadius"})
        if (tool_.corner_radius == 0.0 && parameter->find(key) != nullptr)
          if (auto taken = take_corner(*parameter, key); !taken) return tl::unexpected(taken.error());
    tool_.flutes = flutes(*parameter);
    parameter->find("Units");  // each length has its own
    std::map<std::string, int> unasked;
    root_.count_unasked("", unasked);
    std::string left;
    for (const auto& [key, count] : unasked) left += (left.empty() ? "" : ", ") + key;
    if (!left.empty()) notes.push_back(config::quoted(tool_.name) + ": not carried over: " + left);
    return tool_;
  }

 private:
  Result<void> take(const JsonNode& parameter, const char* key, double& to) {
    const JsonNode* node = parameter.find(key);
    if (node == nullptr) return {};
    const auto length = node->kind == JsonKind::kText ? length_of(one_line(node->text)) : std::nullopt;
    if (!length)
      return fail(Code::kInput,
                  path_ + ": parameter." + key + ": expected a length with its unit, as \"6 mm\"" +
                      (node->kind == JsonKind::kText ? ", found " + config::quoted(node->text) : ""));
    to = *length;
    return {};
  }

  /// FlatRadius is the radius of the flat end within the rounded edge.
  Result<void> take_corner(const JsonNode& parameter, const char* key) {
    double radius = 0.0;
    if (auto taken = take(parameter, key, radius); !taken) return taken;
    tool_.corner_radius = std::string_view(key) == "FlatRadius" ? tool_.diameter / 2.0 - radius : radius;
    return {};
  }

  static int flutes(const JsonNode& parameter) {
    const JsonNode* node = parameter.find("Flutes");
    if (node == nullptr) return 0;
    double value = node->number;
    if (node->kind == JsonKind::kText)
      std::from_chars(node->text.data(), node->text.data() + node->text.size(), value);
    return value >= 0.0 && value <= 100.0 && value == std::floor(value) ? static_cast<int>(value) : 0;
  }

  const JsonNode& root_;
  const std::string& path_;
  ToolEntry tool_;
};

constexpr const char* kLengthNote =
    "a tool bit has no holder, and does not say how far the tool stands out of one: length_mm and "
    "shank_length_mm are to be added";

Result<void> add_bit(const std::string& text, const std::string& path, int number, ToolImport& import) {
  const Result<JsonNode> root = parse_json(text, path);
  if (!root) return tl::unexpected(root.error());
  Result<ToolEntry> tool = Bit(*root, path).read(import.notes);
  if (!tool) return tl::unexpected(tool.error());
  tool->number = number;
  if (tool->type) import.tools.push_back(std::move(*tool));
  return {};
}

/// Where FreeCAD keeps the bit of a library: Tools/Library and Tools/Bit stand side by side.
std::string bit_of(const std::string& library, const std::string& name) {
  const fs::path folder = fs::path(library).parent_path();
  for (const fs::path& place : {folder / name, folder / "Bit" / name, folder / ".." / "Bit" / name}) {
    std::error_code failed;
    if (fs::is_regular_file(place, failed)) return place.lexically_normal().string();
  }
  return "";
}

}  // namespace

Result<ToolImport> read_freecad_bit(const std::string& text, const std::string& path) {
  ToolImport import;
  if (auto added = add_bit(text, path, 0, import); !added) return tl::unexpected(added.error());
  if (!import.tools.empty()) import.notes.push_back(kLengthNote);
  return import;
}

Result<ToolImport> read_freecad_library(const std::string& text, const std::string& path) {
  const Result<JsonNode> root = parse_json(text, path);
  if (!root) return tl::unexpected(root.error());
  const JsonNode* tools = root->find("tools");
  if (tools == nullptr || tools->kind != JsonKind::kList || tools->items.size() > kMostBits)
    return fail(Code::kInput, path + ": no tool library: expected a list of at most 10000 at \"tools\"");
  ToolImport import;
  for (std::size_t i = 0; i < tools->items.size(); ++i) {
    const JsonNode& item = tools->items[i];
    const std::string name = item.text_at("path"), place = "tools[" + std::to_string(i + 1) + "]";
    const double number = item.number_at("nr");
    if (name.empty())
      return fail(Code::kInput, path + ": " + place + ": expected the name of a tool bit at \"path\"");
    const std::string file = bit_of(path, name);
    if (file.empty())
      return fail(Code::kIo, path + ": " + place + ": there is no " + config::quoted(name) +
                                 " beside it, nor in a folder Bit beside it or its folder");
    const Result<std::string> bit = read_tool_file(file);
    if (!bit) return tl::unexpected(bit.error());
    const bool whole = number >= 1.0 && number <= 9999.0 && number == std::floor(number);
    if (auto added = add_bit(*bit, file, whole ? static_cast<int>(number) : 0, import); !added)
      return tl::unexpected(added.error());
  }
  if (!import.tools.empty()) import.notes.push_back(kLengthNote);
  return import;
}

}  // namespace tiltfeed::config
