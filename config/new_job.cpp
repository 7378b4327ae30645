#include "config/new_job.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <sstream>

#include "config/description.h"
#include "config/enum_words.h"
#include "config/job_keys.h"
#include "config/section.h"
#include "config/yaml_edit.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

constexpr double kShankDiameters = 10.0, kLeastShank = 20.0;  // mm
constexpr double kGaugeOverShank = 60.0;                      // mm
constexpr std::size_t kLongestName = 40;
/// The ball of these diameters, mm, that goes so often into the part's longest side.
constexpr double kBalls[] = {16, 12, 10, 8, 6, 5, 4, 3, 2, 1, 0.5};
constexpr double kIntoPart = 40.0;

std::string tidy_vector_text(Vec3 v) { return vector_text({tidy(v.x), tidy(v.y), tidy(v.z)}); }

/// Keys and values of the section axis.
std::vector<YamlEdit> axis_edits(const pathgen::AxisFrame& axis) {
  std::vector<YamlEdit> edits{{"mode", word(kModeWords, axis.mode)}};
  if (axis.mode == pathgen::AxisMode::kIndexed) edits.push_back({"most_directions", "6"});
  if (axis.mode == pathgen::AxisMode::kFree)
    edits.push_back({"plane_normals", "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"});
  if (axis.mode == pathgen::AxisMode::kIndexed || axis.mode == pathgen::AxisMode::kFree) return edits;
  if (axis.mode != pathgen::AxisMode::kFixed) edits.push_back({"sense", word(kSenseWords, axis.sense)});
  edits.push_back({"origin_mm", tidy_vector_text(from_origin(axis.origin))});
  edits.push_back({"t", tidy_vector_text(axis.t)});
  edits.push_back({"n", tidy_vector_text(axis.n)});
  if (axis.mode == pathgen::AxisMode::kCircle)
    edits.push_back({"circle_radius_mm", exact_text(tidy(axis.circle_radius))});
  return edits;
}

std::string axis_text(const pathgen::AxisFrame& axis) {
  std::string text = "axis:\n";
  for (const YamlEdit& edit : axis_edits(axis)) text += "  " + edit.path + ": " + *edit.value + "\n";
  return text;
}

std::string without_outer_blanks(std::string text) {
  const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
  while (!text.empty() && blank(static_cast<unsigned char>(text.back()))) text.pop_back();
  while (!text.empty() && blank(static_cast<unsigned char>(text.front()))) text.erase(0, 1);
  return text;
}

/// TYPE:DIAMETER in full; other texts as they are.
std::string in_full(std::string text) {
  const std::size_t colon = text.find(':');
  if (text.find(',') != text.npos || colon == text.npos || text.find(' ') != text.npos) return text;
  std::istringstream in(text.substr(colon + 1));
  double diameter = 0.0;
  if (!(in >> diameter) || !in.eof() || !(diameter > 0.0)) return text;
  const double shank = std::max(kLeastShank, kShankDiameters * diameter);
  return "type: " + text.substr(0, colon) + ", diameter_mm: " + exact_text(diameter) +
         ", length_mm: " + exact_text(shank + kGaugeOverShank) + ", shank_length_mm: " + exact_text(shank);
}

}  // namespace

namespace {

std::string remarks_text(const std::vector<std::string>& remarks) {
  std::string text;
  for (const std::string& remark : remarks) text += "# " + remark + "\n";
  return text;
}

}  // namespace

std::string new_job_text(const NewJob& job) {
  std::string text = remarks_text(job.remarks);
  if (!job.part_remarks.empty()) text += "\n";
  text += remarks_text(job.part_remarks);
  text += "part:\n  name: " + quoted_text(job.name) + "\n  stl: " + quoted_text(job.stl) + "\n";
  if (job.stl_unit_mm != 1.0) text += "  unit: " + exact_text(job.stl_unit_mm) + "\n";
  text += "\n" + remarks_text(job.cutter_remarks) + "cutter: {" + job.cutter + "}\n\n" + axis_text(job.axis);
  text += "\n" + remarks_text(job.pattern_remarks) +
          "pattern: {direction: zigzag, side_step_mm: " + exact_text(tidy(job.side_step)) + "}\n";
  text += "\ntolerance_mm: " + exact_text(job.tolerance) + "\nclearance_mm: " + exact_text(job.clearance) +
          "\napproach_mm: " + exact_text(job.approach) + "\n";
  text += "\n" + remarks_text(job.feeds_remarks);
  if (!job.feeds.empty()) text += "feeds: {" + job.feeds + "}\n";
  text += "\n" + remarks_text(job.setup_remarks) +
          "setup:\n  part_zero_mm: " + tidy_vector_text(job.part_zero) + "\n";
  if (!(job.fixture_deg == Vec3{}))
    text += "  fixture_rotation_deg: " + tidy_vector_text(job.fixture_deg) + "\n";
  if (job.tilt_max.degrees() < 180.0)
    text += "  tilt_max_deg: " + exact_text(tidy(job.tilt_max.degrees())) + "\n";
  return text + "\nmachine: " + quoted_text(job.machine) + "\n";
}

std::vector<YamlEdit> placement_edits(const NewJob& job) {
  std::vector<YamlEdit> edits;
  for (const YamlEdit& edit : axis_edits(job.axis)) edits.push_back({"axis." + edit.path, edit.value});
  edits.push_back({"clearance_mm", exact_text(job.clearance)});
  edits.push_back({"approach_mm", exact_text(job.approach)});
  edits.push_back({"setup.part_zero_mm", tidy_vector_text(job.part_zero)});
  const bool turned = !(job.fixture_deg == Vec3{}), limited = job.tilt_max.degrees() < 180.0;
  edits.push_back({"setup.fixture_rotation_deg",
                   turned ? std::optional(tidy_vector_text(job.fixture_deg)) : std::nullopt});
  edits.push_back({"setup.tilt_max_deg",
                   limited ? std::optional(exact_text(tidy(job.tilt_max.degrees()))) : std::nullopt});
  return edits;
}

std::string cutter_text(const pathgen::Cutter& cutter) {
  const auto key = [](const char* name, double mm) {
    return std::string(", ") + name + ": " + exact_text(mm);
  };
  std::string text = std::string("type: ") + word(kCutterWords, cutter.type);
  text += key("diameter_mm", cutter.diameter);
  if (cutter.type == pathgen::CutterType::kBullNose) text += key("corner_radius_mm", cutter.corner_radius);
  if (cutter.type == pathgen::CutterType::kTaperBall) text += key("taper_deg", tidy(cutter.taper.degrees()));
  text += key("length_mm", cutter.length);
  if (cutter.cutting_length > 0.0) text += key("cutting_length_mm", cutter.cutting_length);
  if (cutter.shank_diameter > 0.0) text += key("shank_diameter_mm", cutter.shank_diameter);
  text += key("shank_length_mm", cutter.shank_length);
  std::string steps;
  for (const pathgen::HolderStep& step : cutter.holder)
    steps += (steps.empty() ? "{diameter_mm: " : ", {diameter_mm: ") + exact_text(step.lower_diameter) +
             key("upper_diameter_mm", step.upper_diameter) + key("length_mm", step.length) + "}";
  return steps.empty() ? text : text + ", holder: [" + steps + "]";
}

Result<NamedCutter> parse_cutter(const std::string& given) {
  std::string text = without_outer_blanks(given);
  if (text.size() > 1 && text.front() == '{' && text.back() == '}')
    text = without_outer_blanks(text.substr(1, text.size() - 2));
  text = in_full(text);
  const Result<YamlNode> tree = parse_yaml("cutter: {" + text + "}\n", "--cutter");
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint("--cutter");
  const Section root(*tree, "", {"cutter"}, complaint);
  const Section section =
      root.section("cutter", {"type", "diameter_mm", "corner_radius_mm", "taper_deg", "length_mm",
                              "cutting_length_mm", "shank_diameter_mm", "shank_length_mm", "holder"});
  const pathgen::Cutter cutter = read_cutter_form(section);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  return NamedCutter{cutter, text};
}

std::string usual_cutter(double longest) {
  double ball = kBalls[std::size(kBalls) - 1];
  for (const double diameter : kBalls)
    if (diameter * kIntoPart <= longest) {
      ball = diameter;
      break;
    }
  return "ball:" + exact_text(ball);
}

std::string job_name_of(const std::string& stl) {
  std::string name;
  for (const char c : std::filesystem::path(stl).stem().string()) {
    const auto byte = static_cast<unsigned char>(c);
    name += byte < 128 && (std::isalnum(byte) != 0 || c == '.' || c == '_' || c == '-') ? c : '_';
  }
  if (name.size() > kLongestName) name.resize(kLongestName);
  return name.empty() ? "part" : name;
}

}  // namespace tiltfeed::config
