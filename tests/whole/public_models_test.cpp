#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "tests/shapes/public_models.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

const std::string kModels = SOURCE_DIR "/../shared/models/";

constexpr long kMaxResidentKib = 1 << 20;

/// Brute force with ordered maps, sharing nothing with the mesh code.
models::Raw audit(const Stl& stl) {
  std::map<std::array<double, 3>, int> vertices;
  std::map<std::pair<int, int>, std::vector<int>> edges;
  for (const auto& corners : stl.facets) {
    int v[3];
    for (int k = 0; k < 3; ++k) {
      const std::array<double, 3> key{corners[k].x + 0.0, corners[k].y + 0.0, corners[k].z + 0.0};
      v[k] = vertices.try_emplace(key, static_cast<int>(vertices.size())).first->second;
    }
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = v[k], b = v[(k + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}].push_back(a < b);
    }
  }
  models::Raw raw{.facets = stl.facets.size(), .vertices = vertices.size()};
  for (const auto& [ends, forward] : edges) {
    raw.open += forward.size() == 1;
    raw.non_manifold += forward.size() > 2;
    raw.misoriented += forward.size() == 2 && forward[0] == forward[1];
  }
  return raw;
}

models::Defects defects_of(const CheckedMesh& mesh) {
  models::Defects out;
  std::uint64_t* const counts[] = {&out.degenerate,  &out.duplicate, &out.open,       &out.non_manifold,
                                   &out.misoriented, &out.flipped,   &out.inside_out, &out.welded,
                                   &out.split,       &out.flaps,     &out.separated,  &out.filled};
  for (const Defect& d : mesh.defects) *counts[static_cast<int>(d.kind)] = d.count;
  return out;
}

std::string text(const models::Defects& d) {
  return "degenerate " + std::to_string(d.degenerate) + ", duplicate " + std::to_string(d.duplicate) +
         ", open " + std::to_string(d.open) + ", non-manifold " + std::to_string(d.non_manifold) +
         ", misoriented " + std::to_string(d.misoriented) + ", flipped " + std::to_string(d.flipped) +
         ", inside out " + std::to_string(d.inside_out) + ", welded " + std::to_string(d.welded) +
         ", split " + std::to_string(d.split) + ", flaps " + std::to_string(d.flaps) + ", separated " +
         std::to_string(d.separated) + ", filled " + std::to_string(d.filled);
}

void expect_placement(const models::Model& model, const CheckedMesh& mesh) {
  const AxisFrame& axis = model.placement.axis;
  EXPECT_NEAR(length(axis.t), 1.0, 1e-15);
  EXPECT_NEAR(length(axis.n), 1.0, 1e-15);
  EXPECT_NEAR(dot(axis.t, axis.n), 0.0, 1e-15);
  EXPECT_EQ(axis.circle_radius > 0.0, axis.mode == AxisMode::kCircle);
  const Vec3 size = mesh.bounds.max - mesh.bounds.min;
  const double longest = std::max({size.x, size.y, size.z});
  EXPECT_GT(model.placement.ball, longest / 400);
  EXPECT_LT(model.placement.ball, longest / 4);
  EXPECT_GT(model.placement.side_step, 0.0);
}

/// The file gets the answer that its row states.
void expect_answer(const std::string& path, const models::Model& model) {
  SCOPED_TRACE(model.file);
  const Result<Stl> stl = read_stl(path, model.unit_mm);
  Result<CheckedMesh> mesh = stl ? check_mesh(*stl) : tl::unexpected(stl.error());
  ASSERT_EQ(!mesh, model.refused) << (mesh ? "accepted" : mesh.error().message);
  if (!mesh) {
    EXPECT_EQ(mesh.error().code, model.code);
    EXPECT_EQ(mesh.error().message.find(path), 0U) << "no file name: " << mesh.error().message;
    EXPECT_NE(mesh.error().message.find(model.message), std::string::npos) << mesh.error().message;
    return;
  }
  EXPECT_EQ(audit(*stl), model.raw);
  ASSERT_EQ(stl->warnings.size(), model.oddity.empty() ? 0U : 1U);
  if (!model.oddity.empty()) {
    EXPECT_NE(stl->warnings[0].find(model.oddity), std::string::npos) << stl->warnings[0];
  }
  EXPECT_EQ(text(defects_of(*mesh)), text(model.defects));
  EXPECT_EQ(mesh->warnings.size(), mesh->defects.size());
  EXPECT_EQ(mesh->sides, model.sides);
  const std::uint64_t dropped = model.defects.degenerate + model.defects.duplicate;
  EXPECT_EQ(mesh->mesh.facets.size(), model.raw.facets - dropped + model.added);
  if (model.sides == Sides::kBoth) {
    const auto says_why = [](const std::string& w) { return w.find("; not repaired: ") != w.npos; };
    EXPECT_TRUE(std::any_of(mesh->warnings.begin(), mesh->warnings.end(), says_why));
  }
  EXPECT_LE(mesh->mesh.vertices.size(), model.raw.vertices);
  EXPECT_TRUE(std::is_sorted(mesh->mesh.source.begin(), mesh->mesh.source.end()));
  if (model.sides == Sides::kOutward) {
    const double volume = mesh->volume / std::pow(model.unit_mm, 3);
    EXPECT_NEAR(volume, model.volume, model.volume * 2e-5);  // the index has five or six digits
  }
  expect_placement(model, *mesh);
}

// (mesh.h, properties 1 and 3)
TEST(PublicModels, EveryFileGetsItsAnswer) {
  for (const models::Model& model : models::all()) {
    const std::string path = kModels + model.file + ".stl";
    if (std::filesystem::exists(path)) expect_answer(path, model);
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  EXPECT_LT(usage.ru_maxrss, kMaxResidentKib);
}

TEST(PublicModels, EveryFileHasOneRow) {
  std::multiset<std::string> rows;
  for (const models::Model& model : models::all()) rows.insert(model.file);
  for (const std::string& row : rows) EXPECT_EQ(rows.count(row), 1U) << row;
  for (const char* folder : {"public", "paper"}) {
    if (!std::filesystem::exists(kModels + folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(kModels + folder)) {
      if (entry.path().extension() != ".stl") continue;
      EXPECT_TRUE(rows.contains(folder + ("/" + entry.path().stem().string())))
          << entry.path() << " has no row";
    }
  }
}

/// The same road with files made here, so that it is travelled where the models are absent.
TEST(PublicModels, FilesMadeHereGetTheirAnswers) {
  // A tetrahedron in inches, its third facet turned over, one facet twice; then cut short.
  const Point<Part> a{0, 0, 0}, b{3, 0, 0}, c{0, 3, 0}, d{0, 0, 3};
  const std::vector<std::array<Point<Part>, 3>> facets = {
      {a, c, b}, {a, b, d}, {b, d, c}, {c, a, d}, {d, a, b}};
  const std::string path = testing::TempDir() + "made_here.stl";
  ASSERT_TRUE(write_stl(path, facets));
  const models::Placement placement{models::point({10, 10, 10}, {1, 0, 0}, {0, 0, 1}), 3, 2};
  // The duplicate makes three edges non-manifold; the turned facet shares one of them.
  expect_answer(path, models::repaired("made here", 25.4, {5, 4, 0, 3, 2},
                                       {.duplicate = 1, .misoriented = 3, .flipped = 1}, 4.5, placement));
  std::filesystem::resize_file(path, 84 + 5 * 50 - 1);
  expect_answer(
      path, models::refused("made here, cut", Code::kInput,
                            "says 5 facets (334 bytes), but the file is 333 bytes: 4 whole facets and 49"));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace tiltfeed
