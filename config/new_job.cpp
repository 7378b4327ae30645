#include "config/new_job.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <sstream>

#include "config/description.h"
#include "config/enum_words.h"
#include "config/job_keys.h"
#include "config/section.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

constexpr double kShankDiameters = 10.0, kLeastShank = 20.0;  // mm
constexpr double kGaugeOverShank = 60.0;                      // mm
constexpr std::size_t kLongestName = 40;

std::string vector_text(Vec3 v) {
  return "[" + exact_text(tidy(v.x)) + ", " + exact_text(tidy(v.y)) + ", " + exact_text(tidy(v.z)) + "]";
}

std::string quoted_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string axis_text(const pathgen::AxisFrame& axis) {
  std::string text = std::string("axis:\n  mode: ") + word(kModeWords, axis.mode) + "\n";
  if (axis.mode == pathgen::AxisMode::kIndexed) return text + "  most_directions: 6\n";
  if (axis.mode == pathgen::AxisMode::kFree)
    return text + "  plane_normals: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n";
  if (axis.mode != pathgen::AxisMode::kFixed)
    text += std::string("  sense: ") + word(kSenseWords, axis.sense) + "\n";
  text += "  origin_mm: " + vector_text(from_origin(axis.origin)) + "\n";
  text += "  t: " + vector_text(axis.t) + "\n  n: " + vector_text(axis.n) + "\n";
  if (axis.mode == pathgen::AxisMode::kCircle)
    text += "  circle_radius_mm: " + exact_text(tidy(axis.circle_radius)) + "\n";
  return text;
}

std::string trimmed(std::string text) {
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

std::string new_job_text(const NewJob& job) {
  std::string text;
  for (const std::string& remark : job.remarks) text += "# " + remark + "\n";
  text += "part:\n  name: " + quoted_text(job.name) + "\n  stl: " + quoted_text(job.stl) + "\n";
  if (job.stl_unit_mm != 1.0) text += "  unit: " + exact_text(job.stl_unit_mm) + "\n";
  text += "\ncutter: {" + job.cutter + "}\n\n" + axis_text(job.axis);
  text += "\npattern: {direction: zigzag, side_step_mm: " + exact_text(job.side_step) + "}\n";
  text += "\ntolerance_mm: " + exact_text(job.tolerance) + "\nclearance_mm: " + exact_text(job.clearance) +
          "\napproach_mm: " + exact_text(job.approach) + "\n";
  text += "\nfeeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300}   # set them for cutter and material\n";
  text += "\nsetup:\n  part_zero_mm: " + vector_text(job.part_zero) + "\n";
  if (!(job.fixture_deg == Vec3{})) text += "  fixture_rotation_deg: " + vector_text(job.fixture_deg) + "\n";
  if (job.tilt_max.degrees() < 180.0)
    text += "  tilt_max_deg: " + exact_text(tidy(job.tilt_max.degrees())) + "\n";
  return text + "\nmachine: " + quoted_text(job.machine) + "\n";
}

Result<NamedCutter> parse_cutter(const std::string& given) {
  std::string text = trimmed(given);
  if (text.size() > 1 && text.front() == '{' && text.back() == '}')
    text = trimmed(text.substr(1, text.size() - 2));
  text = in_full(text);
  const Result<YamlNode> tree = parse_yaml("cutter: {" + text + "}\n", "--cutter");
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint("--cutter");
  const Section root(*tree, "", {"cutter"}, complaint);
  const pathgen::Cutter cutter = read_cutter(root);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  return NamedCutter{cutter, text};
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
