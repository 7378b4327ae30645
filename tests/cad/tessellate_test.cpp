// Facets of STEP and IGES files against their surfaces in closed form, at 1,000 places each; names, colours
// and units; damaged files.

#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <functional>
#include <map>
#include <random>

#include "cad/shape/iges_file.h"
#include "cad/shape/step_file.h"
#include "cad/shape/surface_gap.h"
#include "cad/shape/tessellate.h"
#include "kinematics/basics/units.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/part_file/cad_stream.h"
#include "tests/cad/cad_shapes.h"
#include "tests/cad/made_files.h"

namespace tiltfeed::cad {
namespace {

using namespace cad_shapes;

Tessellated made(const Result<LoadedPart>& part, double allowed) {
  EXPECT_TRUE(part) << part.error().message;
  if (!part) return {};
  auto all = tessellate(*part, allowed, "f");
  EXPECT_TRUE(all) << all.error().message;
  return all ? std::move(*all) : Tessellated{};
}

/// A surface in closed form: signed distance, positive outside, exact to first order, and its outward normal.
struct Truth {
  const char* file;
  const char* surface;
  std::function<double(Point<Part>)> distance;
  std::function<Vec3(Point<Part>)> normal;
};

double slope(double (*height)(double, double), double x, double y, bool along_x) {
  constexpr double kStep = 1e-5;
  return along_x ? (height(x + kStep, y) - height(x - kStep, y)) / (2 * kStep)
                 : (height(x, y + kStep) - height(x, y - kStep)) / (2 * kStep);
}

std::vector<Truth> truths() {
  const auto radial = [](Point<Part> p) { return Vec3{p.x, p.y, 0.0}; };
  const auto tube = [radial](Point<Part> p) {
    return from_origin(p) - radial(p) * (kTorusMajor / length(radial(p)));
  };
  const auto patch_normal = [](Point<Part> p) {
    return Vec3{-slope(patch_height, p.x, p.y, true), -slope(patch_height, p.x, p.y, false), 1.0};
  };
  // The generating line of the cone falls by 10 mm over 20 mm.
  return {{"cylinder.step", "cylinder", [=](Point<Part> p) { return length(radial(p)) - kCylinderRadius; },
           radial},
          {"sphere.step", "sphere", [](Point<Part> p) { return length(from_origin(p)) - kSphereRadius; },
           [](Point<Part> p) { return from_origin(p); }},
          {"torus.step", "torus", [=](Point<Part> p) { return length(tube(p)) - kTorusMinor; }, tube},
          {"cone.step", "cone",
           [=](Point<Part> p) { return (length(radial(p)) - (kConeLower - 0.5 * p.z)) / std::sqrt(1.25); },
           [=](Point<Part> p) {
             return radial(p) * (1.0 / length(radial(p))) + Vec3{0, 0, 0.5};
           }},
          {"spline.step", "spline",
           [=](Point<Part> p) { return (p.z - patch_height(p.x, p.y)) / length(patch_normal(p)); },
           patch_normal}};
}

/// The spline block has its patch twice, 20 mm apart.
Point<Part> on_top(Point<Part> p, const Truth& truth) {
  if (truth.surface == std::string("spline") && p.z < patch_height(p.x, p.y) - 10.0) p.z += 20.0;
  return p;
}

TEST(Tessellate, LeavesTheSurfaceByNoMoreThanIsAllowedAtAThousandPlaces) {
  constexpr int kPlaces = 1000;
  for (const Truth& truth : truths()) {
    const auto part = load_step(cad_file(truth.file));
    for (const double allowed : {0.05, 0.01}) {
      SCOPED_TRACE(std::string(truth.file) + " " + std::to_string(allowed));
      const Tessellated all = made(part, allowed);
      int faces = 0;
      for (std::size_t i = 0; i < all.facets.size(); ++i) {
        const pathgen::FaceFacets& face = all.facets[i];
        EXPECT_LE(all.model.faces[i].deviation, allowed);
        if (all.model.faces[i].surface != truth.surface) continue;
        ++faces;
        std::mt19937 random(7);
        std::uniform_int_distribution<std::size_t> any(0, face.facets.size() - 1);
        std::uniform_real_distribution<double> share(0.0, 1.0);
        double most = 0.0, middle = 0.0;
        for (int k = 0; k < kPlaces; ++k) {
          const auto& [a, b, c] = face.facets[any(random)];
          double u = share(random), v = share(random);
          if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
          const Point<Part> at = face.corners[a] + (face.corners[b] - face.corners[a]) * u +
                                 (face.corners[c] - face.corners[a]) * v;
          most = std::max(most, std::abs(truth.distance(on_top(at, truth))));
        }
        for (const auto& [a, b, c] : face.facets) {
          const Point<Part> at =
              face.corners[a] +
              ((face.corners[b] - face.corners[a]) + (face.corners[c] - face.corners[a])) * (1.0 / 3);
          middle = std::max(middle, std::abs(truth.distance(on_top(at, truth))));
        }
        EXPECT_LE(most, allowed);
        // What is said is what is: no less than any place shows, and no more than the facets can leave.
        EXPECT_GE(all.model.faces[i].deviation, 0.999 * std::max(most, middle));
        EXPECT_LE(all.model.faces[i].deviation, 4.0 * middle);
      }
      EXPECT_EQ(faces, truth.surface == std::string("spline") ? 2 : 1);
    }
  }
}

TEST(Tessellate, NormalsAreTheSurfacesOwnAndFacetsAreTurnedAsThey) {
  for (const Truth& truth : truths()) {
    SCOPED_TRACE(truth.file);
    const Tessellated all = made(load_step(cad_file(truth.file)), 0.05);
    for (std::size_t i = 0; i < all.facets.size(); ++i) {
      if (all.model.faces[i].surface != truth.surface) continue;
      const pathgen::FaceFacets& face = all.facets[i];
      double agree = 0.0;
      for (std::size_t k = 0; k < face.corners.size(); ++k) {
        const Point<Part> p = face.corners[k];
        Vec3 normal = truth.normal(on_top(p, truth));
        normal = normal * (1.0 / length(normal));
        if (on_top(p, truth).z != p.z) normal = -normal;  // the lower patch looks down
        EXPECT_LT(length(face.normals[k] - normal), 1e-6) << to_string(p);
      }
      for (const auto& [a, b, c] : face.facets)
        agree +=
            dot(cross(face.corners[b] - face.corners[a], face.corners[c] - face.corners[a]), face.normals[a]);
      EXPECT_GT(agree, 0.0);
    }
  }
}

/// Welded, closed, and of the volume of the solid within what the facets leave.
TEST(Tessellate, BodiesAreClosed) {
  const double a = 40.0 * 30.0 * 20.0;
  const std::pair<const char*, double> solids[] = {{"box.step", a},
                                                   {"box_inch.step", a},
                                                   {"pocket.step", a - kPi * 100.0 * 12.0},
                                                   {"cylinder.step", kPi * 400.0 * 30.0},
                                                   {"sphere.step", 4.0 / 3.0 * kPi * 8000.0},
                                                   {"torus.step", 2.0 * kPi * kPi * 20.0 * 25.0},
                                                   {"box.iges", a},
                                                   {"box_inch.iges", a},
                                                   {"pocket.iges", a - kPi * 100.0 * 12.0}};
  for (const auto& [file, volume] : solids) {
    SCOPED_TRACE(file);
    const std::string path = cad_file(file);
    const bool step = path.ends_with(".step");
    const Tessellated all = made(step ? load_step(path) : load_iges(path), 0.01);
    ASSERT_EQ(all.model.bodies.size(), 1u);
    EXPECT_TRUE(all.model.bodies[0].closed);
    const auto read = pathgen::read_cad_stream(pathgen::cad_stream(all.model, all.facets), "f");
    ASSERT_TRUE(read) << read.error().message;
    const auto checked = pathgen::check_mesh(read->mesh, {0.0});
    ASSERT_TRUE(checked) << checked.error().message;
    EXPECT_EQ(checked->sides, pathgen::Sides::kOutward);
    EXPECT_TRUE(checked->defects.empty());
    EXPECT_NEAR(checked->volume, volume, 0.002 * volume);
    EXPECT_EQ(all.model.unit == "inch" || all.model.unit == "INCH",
              std::string(file).find("inch") != std::string::npos)
        << all.model.unit;
    EXPECT_EQ(all.model.unit_mm, std::string(file).find("inch") != std::string::npos ? 25.4 : 1.0);
  }
}

// A flat face has facets on its surface whatever its outline is: its sides are held against its edges.
// Between edges that run close by no facet folds over another.
TEST(Tessellate, AFlatFacesOutlineKeepsToItsEdges) {
  constexpr double kAllowed = 0.002;
  for (const auto& [file, inner] :
       {std::pair{"washer.step", kWasherInner}, std::pair{"ring.step", kRingInner}}) {
    SCOPED_TRACE(file);
    const Tessellated all = made(load_step(cad_file(file)), kAllowed);
    ASSERT_EQ(all.facets.size(), 1u);
    const std::vector<Point<Part>>& corners = all.facets[0].corners;
    double area = 0.0;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& facet : all.facets[0].facets) {
      const Vec3 across =
          cross(corners[facet[1]] - corners[facet[0]], corners[facet[2]] - corners[facet[0]]) * 0.5;
      EXPECT_GT(across.z, 0.0);
      area += across.z;
      for (std::size_t k = 0; k < 3; ++k) ++sides[std::minmax(facet[k], facet[(k + 1) % 3])];
    }
    EXPECT_NEAR(area, kPi * (kRingOuter * kRingOuter - inner * inner), 2.0 * kPi * kRingOuter * kAllowed);
    for (const auto& [side, times] : sides) {
      if (times == 2) continue;
      const Point<Part> middle = lerp(corners[side.first], corners[side.second], 0.5);
      const double radius = std::hypot(middle.x, middle.y);
      EXPECT_LE(std::min(std::abs(radius - kRingOuter), std::abs(radius - inner)), kAllowed);
    }
  }
}

TEST(Tessellate, NamesPlacesAndColours) {
  const Tessellated all = made(load_step(cad_file("assembly.step")), 0.05);
  ASSERT_EQ(all.model.bodies.size(), 3u);
  EXPECT_EQ(all.model.bodies[0].name, "block");
  EXPECT_EQ(all.model.bodies[1].name, "block (2)");
  EXPECT_EQ(all.model.bodies[1].product, "block");
  EXPECT_EQ(all.model.bodies[2].name, "knob");
  int red = 0, green = 0;
  for (std::size_t i = 0; i < all.facets.size(); ++i) {
    const pathgen::PartFace& face = all.model.faces[i];
    EXPECT_FALSE(face.entity.empty());
    if (face.body == 1) {
      for (const Point<Part> p : all.facets[i].corners) EXPECT_TRUE(p.y >= 60.0 - 1e-9 && p.y <= 90.0 + 1e-9);
    }
    if (face.colour == 0xff0000u) {
      ++red;
      for (const Point<Part> p : all.facets[i].corners) EXPECT_NEAR(p.z, 20.0, 1e-9);
    }
    green += face.colour == static_cast<std::uint32_t>(kMixedGreen) << 8;
  }
  EXPECT_EQ(red, 2);  // of both blocks
  EXPECT_EQ(green, 1);
}

void expect_load_refused(const std::string& text, const std::string& name, const std::string& piece) {
  static const Folder folder("cad_damaged");
  const std::string path = folder.write(name, text);
  const auto part = name.ends_with(".step") ? load_step(path) : load_iges(path);
  ASSERT_FALSE(part) << "accepted; expected: " << piece;
  EXPECT_NE(part.error().message.find(piece), std::string::npos)
      << part.error().message << "\nlacks: " << piece;
}

TEST(Tessellate, WhatCannotBeReadIsRefusedByName) {
  const std::string good = file_text(cad_file("pocket.step"));
  expect_load_refused(good.substr(0, good.size() / 2), "cut.step", "cut short in #");
  // A face whose surface is another kind of entity, which the schema does not allow.
  const std::size_t plane = good.find("= PLANE(");
  ASSERT_NE(plane, good.npos);
  expect_load_refused(changed(good, "", "= PLANE(", "= PLANET("), "unknown.step", "#");
  expect_load_refused(changed(good, "", "CYLINDRICAL_SURFACE('',", "CYLINDRICAL_SURFACE('',$,"),
                      "parameters.step", "CYLINDRICAL_SURFACE");
  const std::string iges = file_text(cad_file("pocket.iges"));
  expect_load_refused(iges.substr(0, iges.size() / 2 / 81 * 81), "cut.iges", "cut short");
  expect_load_refused("", "empty.step", "does not begin");
  expect_load_refused(std::string(1000, '\x7f'), "random.step", "does not begin");
}

/// A STEP file may name others, by any path; OpenCASCADE would read them.
TEST(Tessellate, NoFileButThePartIsOpened) {
  static const Folder folder("cad_apart");
  std::string text = file_text(cad_file("apart.step"));
  const std::string whole = cad_file("apart_block.stp"),
                    beside = folder.write("block.stp", file_text(whole)).substr(folder.path.size() + 1);
  ASSERT_NE(text.find("'" + whole + "'"), text.npos) << text;
  const int opened = inotify_init1(IN_NONBLOCK);
  ASSERT_GE(opened, 0);
  for (const std::string& other : {whole, cad_file("apart_knob.stp"), folder.path + "/" + beside})
    ASSERT_GE(inotify_add_watch(opened, other.c_str(), IN_OPEN), 0) << other;
  for (const bool relative : {false, true}) {
    for (std::size_t at = 0; relative && (at = text.find(whole)) != text.npos;)
      text.replace(at, whole.size(), beside);
    const auto part = load_step(folder.write("apart.step", text));
    ASSERT_FALSE(part);
    const std::string& said = part.error().message;
    EXPECT_NE(said.find("refers to another file, \"" + (relative ? beside : whole)), said.npos) << said;
  }
  char bytes[4096];
  EXPECT_EQ(::read(opened, bytes, sizeof bytes), -1) << "another file was opened";
  EXPECT_EQ(errno, EAGAIN);
  ::close(opened);
}

TEST(Tessellate, WhatCannotBeHadWithinTheToleranceIsRefusedByName) {
  // An edge's corner moved off its faces by 0.05 mm.
  const std::string good = file_text(cad_file("box.step"));
  static const Folder folder("cad_loose");
  const std::string moved = changed(good, "CARTESIAN_POINT", "(40.,30.,20.)", "(40.,30.,20.05)");
  const auto part = load_step(folder.write("loose.step", moved));
  if (!part) return;  // refused already
  const auto all = tessellate(*part, 0.01, "loose.step");
  ASSERT_FALSE(all);
  EXPECT_EQ(all.error().code, Code::kMesh);
  EXPECT_NE(all.error().message.find("body \"part\", #"), std::string::npos) << all.error().message;
}

TEST(Tessellate, SameBytesEachTime) {
  const std::string path = cad_file("spline.step");
  const Tessellated a = made(load_step(path), 0.02), b = made(load_step(path), 0.02);
  EXPECT_EQ(pathgen::cad_stream(a.model, a.facets), pathgen::cad_stream(b.model, b.facets));
}

}  // namespace
}  // namespace tiltfeed::cad
