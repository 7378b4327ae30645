#include "pathgen/part_file/three_mf.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "kinematics/basics/decimal.h"
#include "pathgen/part_file/three_mf_objects.h"
#include "pathgen/part_file/xml_walk.h"
#include "pathgen/part_file/zip_archive.h"

namespace tiltfeed::pathgen {
namespace {

constexpr const char* kRelations = "_rels/.rels";
constexpr std::string_view kModelRelation = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
constexpr std::size_t kMostComponents = 100'000;
constexpr int kMostDeep = 100;  // components within components

/// First `inner`, then `outer`.
Transform after(const Transform& inner, const Transform& outer) {
  Transform all{};
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t column = 0; column < 3; ++column) {
      double sum = row == 3 ? outer[9 + column] : 0.0;
      for (std::size_t k = 0; k < 3; ++k) sum += inner[3 * row + k] * outer[3 * k + column];
      all[3 * row + column] = sum;
    }
  return all;
}

Point<Part> moved(const Transform& m, Point<Part> p) {
  return {p.x * m[0] + p.y * m[3] + p.z * m[6] + m[9], p.x * m[1] + p.y * m[4] + p.z * m[7] + m[10],
          p.x * m[2] + p.y * m[5] + p.z * m[8] + m[11]};
}

double determinant(const Transform& m) {
  return dot(cross(Vec3{m[0], m[1], m[2]}, Vec3{m[3], m[4], m[5]}), Vec3{m[6], m[7], m[8]});
}

class Build {
 public:
  Build(const MfModel& model, const std::string& file) : from_(model), file_(file) {}

  Result<PartModel> run() {
    for (const MfComponent& item : from_.items) {
      const MfObject& object = from_.objects.at(item.object);
      if (object.type == "support" || object.type == "solidsupport" || object.type == "other") {
        ++left_out_;
        continue;
      }
      if (auto done = add(item.object, item.transform, product_of(item.object)); !done)
        return tl::unexpected(done.error());
    }
    if (to_.mesh.facets.empty())
      return fail(Code::kInput, file_ + ": nothing of it is built; export the part again");
    to_.format = "3MF", to_.unit = from_.unit, to_.unit_mm = from_.unit_mm;
    to_.mesh.warnings = from_.warnings;
    if (left_out_ > 0)
      to_.mesh.warnings.push_back(file_ + ": " + std::to_string(left_out_) + " supports are left out");
    make_unique();
    return std::move(to_);
  }

 private:
  std::string product_of(std::uint32_t id) const {
    const std::string& name = from_.objects.at(id).name;
    return name.empty() ? "object " + std::to_string(id) : name;
  }

  Result<void> add(std::uint32_t id, const Transform& transform, const std::string& product, int depth = 0) {
    const MfObject& object = from_.objects.at(id);
    if (++components_ > kMostComponents || depth > kMostDeep)
      return fail(Code::kLimit, file_ + ": over the limit of " + std::to_string(kMostComponents) +
                                    " components, or " + std::to_string(kMostDeep) +
                                    " within each other, at object " + std::to_string(id));
    for (const MfComponent& component : object.components)
      if (auto done = add(component.object, after(component.transform, transform), product, depth + 1); !done)
        return done;
    if (object.facets.empty()) return {};
    if (to_.mesh.facets.size() + object.facets.size() > kMaxFacets)
      return fail(Code::kLimit, file_ + ": over the limit of " + std::to_string(kMaxFacets) +
                                    " facets at object " + std::to_string(id) +
                                    "; export with a coarser tolerance");
    const double det = determinant(transform);
    if (!(std::abs(det) > 0.0) || !std::isfinite(det))
      return fail(Code::kInput, file_ + ": the transform of object " + std::to_string(id) +
                                    " makes it flat; export the part again");
    std::vector<Point<Part>> corners;
    corners.reserve(object.corners.size());
    for (const Point<Part> corner : object.corners) {
      const Point<Part> p = moved(transform, corner);
      corners.push_back({p.x * from_.unit_mm, p.y * from_.unit_mm, p.z * from_.unit_mm});
      const Point<Part>& q = corners.back();
      if (!is_finite(q) || std::max({std::abs(q.x), std::abs(q.y), std::abs(q.z)}) > kMaxCoordinate)
        return fail(Code::kMesh, file_ + ": object " + std::to_string(id) + " has a vertex at " +
                                     to_string(q) + " mm, beyond the limit of " +
                                     number_text(kMaxCoordinate, 7) +
                                     " mm; move the part to its origin, or check its unit");
    }
    const auto body = static_cast<std::uint32_t>(to_.bodies.size());
    to_.bodies.push_back({product_of(id), product, object.type != "surface"});
    std::map<std::uint32_t, std::uint32_t> face_of;  // by material
    for (std::size_t i = 0; i < object.facets.size(); ++i) {
      const auto [at, fresh] =
          face_of.try_emplace(object.material[i], static_cast<std::uint32_t>(to_.faces.size()));
      if (fresh) to_.faces.push_back(face(body, id, object.material[i]));
      auto [a, b, c] = object.facets[i];
      if (det < 0.0) std::swap(b, c);
      to_.mesh.facets.push_back({corners[a], corners[b], corners[c]});
      to_.face_of.push_back(at->second);
    }
    return {};
  }

  PartFace face(std::uint32_t body, std::uint32_t id, std::uint32_t material) const {
    PartFace one;
    one.body = body, one.surface = "facets", one.entity = "object " + std::to_string(id);
    if (material > 0)
      one.name = from_.materials[material - 1].name, one.colour = from_.materials[material - 1].colour;
    return one;
  }

  void make_unique() {
    std::set<std::string> taken;
    for (PartBody& body : to_.bodies) {
      const std::string name = body.name;
      for (int i = 2; !taken.insert(body.name).second; ++i) body.name = name + " (" + std::to_string(i) + ")";
    }
  }

  const MfModel& from_;
  const std::string& file_;
  PartModel to_;
  std::size_t components_ = 0, left_out_ = 0;
};

/// The entry with the model.
Result<std::string> model_entry(const ZipArchive& zip, const std::string& file) {
  std::string target;
  if (zip.has(kRelations)) {
    const auto text = zip.read(kRelations);
    if (!text) return tl::unexpected(text.error());
    const XmlHandlers handlers{
        [&](std::string_view name, const XmlAttributes& a) -> Result<void> {
          const char *type = a.find("Type"), *to = a.find("Target");
          if (name.ends_with("|Relationship") && type != nullptr && to != nullptr && type == kModelRelation)
            target = to;
          return {};
        },
        [](std::string_view) -> Result<void> { return {}; }};
    if (auto done = walk_xml(*text, file + ": " + kRelations, handlers); !done)
      return tl::unexpected(done.error());
  }
  if (target.starts_with('/')) target.erase(0, 1);
  if (target.empty()) target = "3D/3dmodel.model";
  if (!zip.has(target))
    return fail(Code::kInput, file + ": this is no 3MF file: the archive has no model " + target);
  return target;
}

}  // namespace

Result<PartModel> parse_three_mf(std::span<const char> bytes, const std::string& file) {
  const auto zip = ZipArchive::open(bytes, file);
  if (!zip) return tl::unexpected(zip.error());
  const auto entry = model_entry(*zip, file);
  if (!entry) return tl::unexpected(entry.error());
  const auto xml = zip->read(*entry);
  if (!xml) return tl::unexpected(xml.error());
  const auto model = read_mf_model(*xml, file + ": " + *entry);
  if (!model) return tl::unexpected(model.error());
  return Build(*model, file).run();
}

Result<PartModel> read_three_mf(const std::string& path) {
  std::error_code error;
  const auto size =
      std::filesystem::is_regular_file(path, error) ? std::filesystem::file_size(path, error) : 0;
  if (error || size == 0)
    return fail(Code::kIo, path + ": cannot read: " + (error ? error.message() : "not a regular file"));
  if (size > kMaxStlBytes)
    return fail(Code::kLimit, path + ": " + std::to_string(size) + " bytes are over the limit of " +
                                  std::to_string(kMaxStlBytes) + "; export with a coarser tolerance");
  std::string bytes(size, '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size)))
    return fail(Code::kIo, path + ": cannot read");
  return parse_three_mf(bytes, path);
}

}  // namespace tiltfeed::pathgen
