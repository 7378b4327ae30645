// Tool libraries of Fusion 360, exported as JSON: {"data": [tools], "version": N}. Each tool states its unit.

#include <algorithm>
#include <cmath>
#include <map>

#include "config/description.h"
#include "config/json_tree.h"
#include "config/key_ranges.h"
#include "config/tool_readers.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

constexpr double kSame = 1e-6;  // mm: rounding between units

/// Millimetres of a tool's or holder's own unit; 0: another word.
double unit_of_node(const JsonNode& node, double usual) {
  const std::string unit = node.text_at("unit");
  if (unit.empty()) return usual;
  if (unit == "millimeters" || unit == "mm") return 1.0;
  return unit == "inches" || unit == "in" ? 25.4 : 0.0;
}

int whole(double value, int most) {
  return value >= 0.0 && value <= most && value == std::floor(value) ? static_cast<int>(value) : 0;
}

class FusionTool {
 public:
  FusionTool(const JsonNode& node, std::vector<std::string>& notes) : node_(node), notes_(notes) {}

  /// Nothing where it is left out, which is noted. Errors: what is malformed, without the file.
  Result<std::optional<ToolEntry>> read() {
    node_.find("type");
    tool_.name = node_.text_at("description");
    tool_.vendor = node_.text_at("vendor");
    tool_.product = node_.text_at("product-id");
    if (const JsonNode* post = node_.find("post-process")) {
      tool_.number = whole(post->number_at("number"), kHighestToolNumber);
      // The same number again, as the control's offsets.
      for (const char* key : {"diameter-offset", "length-offset"})
        if (post->find(key) != nullptr && post->number_at(key) != tool_.number)
          note(std::string("post-process.") + key +
               " is another number than the tool's, and was not carried over");
    }
    if (!take_form()) return std::nullopt;
    unit_ = unit_of_node(node_, 0.0);
    if (unit_ == 0.0)
      return fail(Code::kInput,
                  "unit: expected millimeters or inches, found " + quoted(node_.text_at("unit")));
    const JsonNode* geometry = node_.find("geometry");
    if (geometry == nullptr || geometry->kind != JsonKind::kMap)
      return fail(Code::kInput, "geometry: missing; expected a map with DC and the other sizes");
    take_geometry(*geometry);
    take_shaft();
    if (auto taken = take_holder(); !taken) return tl::unexpected(taken.error());
    settle_shank();
    take_presets();
    return tool_;
  }

 private:
  void note(const std::string& text) {
    const std::string name = tool_.name.empty() ? "T" + std::to_string(tool_.number) : tool_.name;
    notes_.push_back(quoted(name) + ": " + text);
  }

  bool take_form() {
    const std::string type = node_.text_at("type"), taper = node_.text_at("tapered-type");
    if (type == "ball end mill") tool_.type = pathgen::CutterType::kBall;
    if (type == "bull nose end mill") tool_.type = pathgen::CutterType::kBullNose;
    if (type == "flat end mill") tool_.type = pathgen::CutterType::kFlat;
    if (type == "tapered mill" && taper.find("ball") != taper.npos)
      tool_.type = pathgen::CutterType::kTaperBall;
    if (tool_.type) return true;
    note("left out: " + quoted(taper.empty() ? type : type + ", " + taper) + " is no form of a cutter here");
    node_.pass_over();
    return false;
  }

  void take_geometry(const JsonNode& geometry) {
    const auto mm = [&](const char* key) { return unit_ * geometry.number_at(key); };
    tool_.diameter = mm("DC");
    const double corner = mm("RE");
    if (*tool_.type == pathgen::CutterType::kBullNose) tool_.corner_radius = corner;
    if (*tool_.type == pathgen::CutterType::kBullNose && corner > 0.0 &&
        std::abs(2.0 * corner - tool_.diameter) < kSame)
      tool_.type = pathgen::CutterType::kBall, tool_.corner_radius = 0.0;
    if (*tool_.type == pathgen::CutterType::kFlat && corner > 0.0)
      note("RE " + exact_text(tidy(corner)) + " mm of a flat end mill was not carried over");
    if (*tool_.type == pathgen::CutterType::kTaperBall) {
      tool_.diameter = 2.0 * corner;
      note("taper_deg is to be added: TA " + exact_text(geometry.number_at("TA")) +
           " may be the half or the whole angle; diameter_mm is taken from RE");
    }
    tool_.flutes = whole(geometry.number_at("NOF"), kMostFlutes);
    tool_.cutting_length = mm("LCF");
    tool_.shank_length = mm("LB");
    tool_.shank_diameter = mm("SFDM");
    neck_ = mm("shoulder-diameter");
    assembly_ = mm("assemblyGaugeLength");
    // The whole tool's length says nothing of how it is held; a neck as long as the edge is none.
    geometry.find("OAL");
    if (mm("shoulder-length") > tool_.cutting_length + kSame &&
        (neck_ > 0.0 && neck_ < tool_.shank_diameter - kSame))
      note("the neck of " + exact_text(tidy(neck_)) + " mm is taken as wide as the shank, " +
           exact_text(tidy(tool_.shank_diameter)) + " mm");
  }

  /// All of the shaft as wide as its widest: what keeps clear with that does with the true one.
  void take_shaft() {
    const JsonNode* shaft = node_.find("shaft");
    const JsonNode* segments = shaft == nullptr ? nullptr : shaft->find("segments");
    if (segments == nullptr || segments->items.empty()) return;
    const double unit = unit_of_node(*shaft, unit_);
    double widest = tool_.shank_diameter;
    for (const JsonNode& segment : segments->items) {
      for (const char* key : {"lower-diameter", "upper-diameter"})
        widest = std::max(widest, unit * segment.number_at(key));
      segment.pass_over();
    }
    note("the shaft of " + std::to_string(segments->items.size()) + " steps is taken as one of " +
         exact_text(tidy(widest)) + " mm, its widest");
    tool_.shank_diameter = widest;
  }

  Result<void> take_holder() {
    const JsonNode* holder = node_.find("holder");
    double gauge = 0.0;
    if (holder != nullptr && holder->kind == JsonKind::kMap) {
      const double unit = unit_of_node(*holder, unit_);
      if (unit == 0.0) return fail(Code::kInput, "holder.unit: expected millimeters or inches");
      for (const char* key : {"description", "guid", "product-id", "product-link", "type", "vendor"})
        holder->find(key);
      gauge = unit * holder->number_at("gaugeLength");
      if (const JsonNode* segments = holder->find("segments"))
        for (const JsonNode& segment : segments->items) add_step(segment, unit);
    }
    // Without a holder it repeats LB.
    if (assembly_ <= tool_.shank_length + kSame) assembly_ = 0.0;
    if (assembly_ > 0.0)
      tool_.length = assembly_;
    else if (gauge > 0.0 && tool_.shank_length > 0.0)
      tool_.length = tool_.shank_length + gauge;
    const double sum = tool_.shank_length + gauge;
    if (assembly_ > 0.0 && gauge > 0.0 && std::abs(assembly_ - sum) > 0.01)
      note("assemblyGaugeLength " + exact_text(tidy(assembly_)) +
           " mm is taken for length_mm; LB and gaugeLength make " + exact_text(tidy(sum)));
    if (tool_.length == 0.0) note("length_mm is to be added: no gauge length is stated");
    return {};
  }

  /// A step without height is the edge between its neighbours.
  void add_step(const JsonNode& segment, double unit) {
    pathgen::HolderStep step{unit * segment.number_at("lower-diameter"),
                             unit * segment.number_at("upper-diameter"), unit * segment.number_at("height")};
    const double wide = std::max(step.lower_diameter, step.upper_diameter);
    if (step.lower_diameter <= 0.0) step.lower_diameter = wide;
    if (step.upper_diameter <= 0.0) step.upper_diameter = wide;
    if (step.length > 0.0 && wide > 0.0) tool_.holder.push_back(step);
  }

  /// A shank is what lies between edge and holder.
  void settle_shank() {
    const bool edge_to_holder =
        tool_.shank_length > 0.0 && tool_.cutting_length >= tool_.shank_length - kSame;
    if (edge_to_holder && tool_.cutting_length > tool_.shank_length + kSame)
      note("LCF " + exact_text(tidy(tool_.cutting_length)) + " mm goes beyond LB " +
           exact_text(tidy(tool_.shank_length)) + " mm; it is taken to end there");
    if (edge_to_holder) tool_.cutting_length = tool_.shank_diameter = 0.0;
    if (tool_.cutting_length == 0.0) tool_.shank_diameter = 0.0;
  }

  void take_presets() {
    const JsonNode* start = node_.find("start-values");
    const JsonNode* presets = start == nullptr ? nullptr : start->find("presets");
    if (presets == nullptr) return;
    for (const JsonNode& preset : presets->items) {
      preset.find("guid");
      // Speed and feed again, by the edge.
      for (const char* key : {"v_c", "f_z", "f_n"}) preset.find(key);
      CuttingData data{material_of(preset), preset.number_at("n"), unit_ * preset.number_at("v_f"),
                       unit_ * preset.number_at("v_f_plunge")};
      const std::string name = data.material;
      for (int i = 2; std::any_of(tool_.data.begin(), tool_.data.end(),
                                  [&](const CuttingData& other) { return other.material == data.material; });
           ++i)
        data.material = name + " (" + std::to_string(i) + ")";
      tool_.data.push_back(data);
    }
  }

  static std::string material_of(const JsonNode& preset) {
    const std::string name = preset.text_at("name");
    const JsonNode* material = preset.find("material");
    const std::string query = material == nullptr ? "" : material->text_at("query");
    const std::string category = material == nullptr ? "" : material->text_at("category");
    if (!query.empty()) return query;
    if (!category.empty() && category != "all") return category;
    return name.empty() ? "preset" : name;
  }

  const JsonNode& node_;
  std::vector<std::string>& notes_;
  ToolEntry tool_;
  double unit_ = 1.0, neck_ = 0.0, assembly_ = 0.0;
};

}  // namespace

Result<ToolImport> read_fusion_tools(const std::string& text, const std::string& path) {
  const Result<JsonNode> root = parse_json(text, path);
  if (!root) return tl::unexpected(root.error());
  const JsonNode* data = root->find("data");
  if (data == nullptr || data->kind != JsonKind::kList)
    return fail(Code::kInput, path + ": no tool library of Fusion 360: expected a list at \"data\"");
  ToolImport import;
  std::map<std::string, int> unasked;
  for (std::size_t i = 0; i < data->items.size(); ++i) {
    const JsonNode& node = data->items[i];
    auto tool = FusionTool(node, import.notes).read();
    if (!tool)
      return fail(Code::kInput, path + ": data[" + std::to_string(i + 1) + "]: " + tool.error().message);
    node.find("guid");
    node.count_unasked("", unasked);
    if (*tool) import.tools.push_back(std::move(**tool));
  }
  std::string left;
  for (const auto& [key, count] : unasked)
    left += (left.empty() ? "" : ", ") + key + " (" + std::to_string(count) + ")";
  if (!left.empty()) import.notes.push_back("not carried over, and of how many tools: " + left);
  return import;
}

}  // namespace tiltfeed::config
