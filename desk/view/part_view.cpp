#include "desk/view/part_view.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>

#include "config/new_job.h"
#include "config/part_reading.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl_facets.h"
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

/// All that names can choose: bodies, and faces with what they are called by.
json describe_model(const pathgen::PartModel& model) {
  json bodies = json::array(), faces = json::array();
  for (const pathgen::PartBody& body : model.bodies)
    bodies.push_back({{"name", body.name}, {"product", body.product}, {"solid", body.closed}});
  for (const pathgen::PartFace& face : model.faces)
    faces.push_back({{"body", face.body},
                     {"name", face.name},
                     {"colour", face.colour ? pathgen::colour_text(*face.colour) : ""},
                     {"surface", face.surface}});
  return {{"format", model.format}, {"bodies", bodies}, {"faces", faces}};
}

json describe_part(const PartView& view, const std::string& unit, double unit_mm) {
  const pathgen::Box& box = view.checked.bounds;
  json defects = json::array(), units = json::array();
  for (const pathgen::Defect& defect : view.checked.defects)
    defects.push_back({{"kind", to_string(defect.kind)}, {"count", defect.count}, {"first", defect.first}});
  const bool mesh_file = view.model.format.empty();
  for (const StlUnit& other : mesh_file ? likelier_units(box, unit_mm) : std::vector<StlUnit>{}) {
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
          {"format", view.model.format},
          {"file_unit", view.model.unit},
          {"bodies", view.model.bodies.size()},
          {"faces", view.model.faces.size()},
          {"deviation_mm", view.model.deviation},
          {"odd_size", !is_common(longest_side(box))}};
}

template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

Result<void> write_bytes(const std::string& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) return fail(Code::kIo, path + ": cannot be written; is the disk full?");
  return {};
}

std::string text_of(const json& value) { return value.dump(-1, ' ', true, json::error_handler_t::replace); }

/// Of the whole file: those of bodies that are not asked for, too, so that they can be asked for. A body that
/// cannot be read does no harm to others.
Result<pathgen::PartModel> read_whole(const PartAsked& asked, double unit_mm) {
  auto whole = config::read_part_file({asked.path, unit_mm, {}, asked.deviation});
  if (whole || asked.bodies.empty()) return whole;
  auto some = config::read_part_file({asked.path, unit_mm, asked.bodies, asked.deviation});
  if (some)
    some->mesh.warnings.push_back("only the bodies of the job could be read: " + whole.error().message);
  return some;
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

Result<PartView> view_part(const PartAsked& asked,
                           const std::function<Result<void>(const pathgen::PartModel&)>& listed) {
  const std::optional<double> unit_mm = unit_length(asked.unit);
  if (!unit_mm)
    return fail(Code::kUsage, "'" + asked.unit + "' is no unit of an STL; expected mm, inch or m");
  Result<pathgen::PartModel> model = read_whole(asked, *unit_mm);
  if (!model) return tl::unexpected<Error>(model.error());
  if (listed)
    if (const Result<void> told = listed(*model); !told) return tl::unexpected<Error>(told.error());
  PartView view;
  view.model = *model;
  view.model.mesh = {}, view.model.face_of.clear();
  if (const Result<void> kept = pathgen::keep_bodies(*model, asked.bodies, asked.path); !kept)
    return tl::unexpected<Error>(kept.error());
  // Faces that are kept are in the order of all.
  for (const pathgen::PartBody& body : view.model.bodies)
    view.drawn.push_back(std::any_of(model->bodies.begin(), model->bodies.end(),
                                     [&](const pathgen::PartBody& kept) { return kept.name == body.name; }));
  std::vector<std::uint32_t> number;
  for (std::uint32_t i = 0; i < view.model.faces.size(); ++i)
    if (view.drawn[view.model.faces[i].body]) number.push_back(i);
  for (const std::uint32_t face : model->face_of) view.face_of.push_back(number[face]);
  const pathgen::Stl& stl = model->mesh;
  view.corners.reserve(stl.facets.size() * 9);
  for (const auto& facet : stl.facets)
    for (const Point<Part>& corner : facet) append(view.corners, corner);
  Result<pathgen::CheckedMesh> checked = pathgen::check_mesh(stl);
  if (!checked) return tl::unexpected<Error>(checked.error());
  view.checked = std::move(*checked);
  mark_edges(stl, view);
  view.warnings = stl.warnings;
  view.warnings.insert(view.warnings.end(), view.checked.warnings.begin(), view.checked.warnings.end());
  if (!asked.avoid.empty())
    if (const auto named = pathgen::faces_named(*model, asked.avoid, "part.avoid_faces"); !named)
      view.warnings.push_back(named.error().message);
  return view;
}

Result<void> write_part_view(const PartAsked& asked, const std::string& folder) {
  const std::string at = folder + "/";
  const Result<PartView> view = view_part(asked, [&](const pathgen::PartModel& model) {
    return write_bytes(at + "model.json", text_of(describe_model(model)));
  });
  if (!view) return tl::unexpected<Error>(view.error());
  const std::string text = text_of(describe_part(*view, asked.unit, *unit_length(asked.unit)));
  for (const auto& [name, bytes] :
       {std::pair<const char*, std::string_view>{"mesh.f32", bytes_of(view->corners)},
        {"edges.f32", bytes_of(view->edges)},
        {"faces.u32", bytes_of(view->face_of)},
        {"part.json", text}})
    if (const Result<void> written = write_bytes(at + name, bytes); !written) return written;
  return {};
}

}  // namespace tiltfeed::desk
