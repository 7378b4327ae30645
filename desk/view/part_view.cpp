#include "desk/view/part_view.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>

#include "config/new_job.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/mesh/topology.h"
#include "pathgen/mesh/weld.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

void append(std::vector<float>& out, Point<Part> p) {
  for (const double value : {p.x, p.y, p.z}) out.push_back(static_cast<float>(value));
}

void mark_edges(const pathgen::Stl& stl, PartView& view) {
  const pathgen::Welded welded = pathgen::weld(stl);
  if (welded.survey.all_sound) return;
  const std::vector<Point<Part>>& at = welded.mesh.vertices;
  welded.fans.each_edge([&](std::span<const pathgen::HalfEdge> edge) {
    if (state(edge) == pathgen::EdgeState::kSound || ++view.bad_edges > kMostEdges) return;
    append(view.edges, at[edge[0].low]);
    append(view.edges, at[edge[0].high]);
  });
}

bool is_common(double longest) { return longest >= kLeastPart && longest <= kLargestPart; }

double longest_side(const pathgen::Box& bounds) {
  const Vec3 size = bounds.max - bounds.min;
  return std::max({size.x, size.y, size.z});
}

json coordinates(Point<Part> p) { return {p.x, p.y, p.z}; }

json describe_part(const PartView& view, const std::string& unit, double unit_mm) {
  const pathgen::Box& box = view.checked.bounds;
  json defects = json::array(), units = json::array();
  for (const pathgen::Defect& defect : view.checked.defects)
    defects.push_back({{"kind", to_string(defect.kind)}, {"count", defect.count}, {"first", defect.first}});
  for (const StlUnit& other : likelier_units(box, unit_mm)) {
    const Vec3 size = (box.max - box.min) * (other.mm / unit_mm);
    units.push_back({{"unit", other.word}, {"size_mm", {size.x, size.y, size.z}}});
  }
  return {{"facets", view.corners.size() / 9},
          {"unit", unit},
          {"min_mm", coordinates(box.min)},
          {"max_mm", coordinates(box.max)},
          {"closed", view.checked.sides == pathgen::Sides::kOutward},
          {"volume_mm3", view.checked.volume},
          {"bad_edges", view.bad_edges},
          {"marked_edges", view.edges.size() / 6},
          {"defects", defects},
          {"warnings", view.warnings},
          {"likelier_units", units},
          {"usual_cutter", config::usual_cutter(longest_side(box))},
          {"odd_size", !is_common(longest_side(box))}};
}

std::string_view bytes_of(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

}  // namespace

std::optional<double> unit_length(const std::string& unit) {
  for (const StlUnit& known : kStlUnits)
    if (unit == known.word) return known.mm;
  double mm = 0.0;
  const auto [end, error] = std::from_chars(unit.data(), unit.data() + unit.size(), mm);
  const bool whole = error == std::errc{} && end == unit.data() + unit.size();
  if (!whole || !(mm > 0.0) || mm > kLargestPart * kLargestPart) return std::nullopt;
  return mm;
}

std::vector<StlUnit> likelier_units(const pathgen::Box& bounds, double unit_mm) {
  std::vector<StlUnit> found;
  const double longest = longest_side(bounds);
  if (is_common(longest)) return found;
  for (const StlUnit& unit : kStlUnits)
    if (is_common(longest * unit.mm / unit_mm)) found.push_back(unit);
  return found;
}

Result<PartView> view_part(const std::string& path, double unit_mm) {
  const Result<pathgen::Stl> stl = pathgen::read_stl(path, unit_mm);
  if (!stl) return tl::unexpected<Error>(stl.error());
  PartView view;
  view.corners.reserve(stl->facets.size() * 9);
  for (const auto& facet : stl->facets)
    for (const Point<Part>& corner : facet) append(view.corners, corner);
  Result<pathgen::CheckedMesh> checked = pathgen::check_mesh(*stl);
  if (!checked) return tl::unexpected<Error>(checked.error());
  view.checked = std::move(*checked);
  mark_edges(*stl, view);
  view.warnings = stl->warnings;
  view.warnings.insert(view.warnings.end(), view.checked.warnings.begin(), view.checked.warnings.end());
  return view;
}

Result<void> write_part_view(const std::string& stl, const std::string& unit, const std::string& folder) {
  const std::optional<double> unit_mm = unit_length(unit);
  if (!unit_mm) return fail(Code::kUsage, "'" + unit + "' is no unit of an STL; expected mm, inch or m");
  const Result<PartView> view = view_part(stl, *unit_mm);
  if (!view) return tl::unexpected<Error>(view.error());
  const std::string text =
      describe_part(*view, unit, *unit_mm).dump(-1, ' ', true, json::error_handler_t::replace);
  const std::pair<const char*, std::string_view> files[] = {
      {"mesh.f32", bytes_of(view->corners)}, {"edges.f32", bytes_of(view->edges)}, {"part.json", text}};
  for (const auto& [name, bytes] : files) {
    std::ofstream out(folder + "/" + name, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) return fail(Code::kIo, folder + "/" + name + ": cannot be written; is the disk full?");
  }
  return {};
}

}  // namespace tiltfeed::desk
