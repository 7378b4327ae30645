#include "sim/parts/parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <ostream>
#include <set>

#include "tests/shapes/welded.h"

namespace tiltfeed::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Measures {
  double volume = 0.0, longest_edge = 0.0, lowest_height = 1e9;
  Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
};

Measures measure(const Triangles& triangles) {
  Measures m;
  for (const auto& [a, b, c] : triangles) {
    m.volume += dot(from_origin(a), cross(from_origin(b), from_origin(c))) / 6.0;
    const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
    m.longest_edge = std::max(m.longest_edge, longest);
    m.lowest_height = std::min(m.lowest_height, length(cross(b - a, c - a)) / longest);
    for (const Point<Part>& p : {a, b, c}) {
      m.low = {std::min(m.low.x, p.x), std::min(m.low.y, p.y), std::min(m.low.z, p.z)};
      m.high = {std::max(m.high.x, p.x), std::max(m.high.y, p.y), std::max(m.high.z, p.z)};
    }
  }
  return m;
}

/// FNV-1a over the float32 corners: the bytes of the STL without its normals.
std::uint64_t hash_of(const Triangles& triangles) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const auto& triangle : triangles) {
    for (const Point<Part>& p : triangle) {
      for (const double value : {p.x, p.y, p.z}) {
        const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
        for (int byte = 0; byte < 4; ++byte) hash = (hash ^ (bits >> 8 * byte & 255)) * 1099511628211ull;
      }
    }
  }
  return hash;
}

// Volumes in closed form, without the chords.
double shell_volume() {
  const auto cap = [](double radius, double hole) { return std::pow(radius * radius - hole * hole, 1.5); };
  const double shell = 4.0 / 3.0 * std::numbers::pi * (50.0 * 50.0 * 50.0 - 40.0 * 40.0 * 40.0);
  const double hole =
      2.0 / 3.0 * std::numbers::pi * (cap(50.0, 0.0) - cap(50.0, 18.0) - cap(40.0, 0.0) + cap(40.0, 18.0));
  return shell - 3.0 * hole;
}
double pin_volume() {
  const auto under_arc = [](double r) { return std::sqrt(r * r - 1.0) + r * r * std::asin(1.0 / r); };
  return std::numbers::pi * (100.0 - 49.0) * 62.0 + 72.0 * 6.0 * (under_arc(23.0) - under_arc(10.0));
}
/// The sector of a ring without tread, and the ribs by their mean widths.
double tyre_volume() {
  const double sector = 40.0 * kDegree, edge = 55.0 * kDegree, draft = std::tan(5.0 * kDegree);
  double ring = 0.0, ribs = 0.0;
  constexpr int kSteps = 2000;
  for (int i = 0; i < kSteps; ++i) {
    const double phi = edge * (2.0 * (i + 0.5) / kSteps - 1.0), r = 280.0 + 90.0 * std::cos(phi);
    ring += 0.5 * sector * (410.0 * 410.0 - r * r) * 90.0 * std::cos(phi) * 2.0 * edge / kSteps;
  }
  for (const double phi : {11.0, 33.0})
    ribs += 2.0 * 8.0 * (9.3 - 8.0 * draft) * (280.0 + 86.0 * std::cos(phi * kDegree)) * sector;
  const auto lateral = [&](double height, double degrees, double from, double to) {
    const double middle = 0.5 * (from + to) * kDegree, rho = 90.0 - 0.5 * height;
    const double width = degrees * kDegree * (280.0 + rho * std::cos(middle)) - height * draft;
    return 9.0 * height * width * rho * (to - from) * kDegree;
  };
  const double cell = 40.0 / 198.0;
  ribs += lateral(5.0, 5.0 * cell, -8.0, 8.0);
  ribs += 2.0 * (lateral(7.0, 5.0 * cell, 14.0, 30.0) + lateral(7.0, 5.0 * cell, 36.0, 51.4));
  ribs += 2.0 * (lateral(4.0, 2.0 * cell, 18.1, 25.9) + lateral(4.0, 2.0 * cell, 40.1, 49.9));
  return ring + ribs;
}

struct Expected {
  const char* name;
  std::size_t facets;
  int genus;
  double volume, volume_tolerance;  ///< the tolerance relative
  Vec3 low, high;
  double longest_edge;
  std::uint64_t hash;
  const char* file;
};

void PrintTo(const Expected& part, std::ostream* out) { *out << part.name; }

std::vector<Expected> expected_parts() {
  return {{"tyre",
           236'748,
           0,
           tyre_volume(),
           0.002,
           {-140.23, -73.72, -410},
           {140.23, 73.72, -311.62},
           2.0,
           0xf62eefdd8e9f3281,
           "tyre_236748.stl"},
          {"pin",
           55'818,
           1,
           pin_volume(),
           0.002,
           {-23, 0, -23},
           {23, 62, 23},
           2.0,
           0x0962793ccac1b568,
           "pin_55818.stl"},
          {"sphere",
           4'446,
           2,
           shell_volume(),
           0.006,
           {-50, -50, -50},
           {50, 50, 50},
           9.0,
           0x1e01aa6034e99ce1,
           "sphere_4446_closed.stl"},
          {"handle",
           23'780,
           0,
           49'184.0,
           0.01,
           {-70, -15, 0},
           {70, 15, 44.7},
           3.0,
           0x0b5bf4270969f3e9,
           "handle_23780_closed.stl"}};
}

class Part4 : public testing::TestWithParam<Expected> {
 protected:
  const Expected& want_ = GetParam();
  const Triangles part_ = part_by_name(want_.name).value();
};

TEST_P(Part4, IsAClosedOrientedSurfaceOfTheGenus) {
  ASSERT_EQ(part_.size(), want_.facets);
  const Welded mesh = weld(part_);
  EXPECT_FALSE(mesh.edge_twice);
  for (const auto& [from, to] : mesh.edges) ASSERT_TRUE(mesh.edges.contains({to, from})) << from << " " << to;
  const long euler = static_cast<long>(mesh.vertices.size()) - static_cast<long>(mesh.edges.size() / 2) +
                     static_cast<long>(mesh.facets.size());
  EXPECT_EQ(euler, 2 - 2 * want_.genus);
  std::set<std::array<int, 3>> corners;
  for (std::array<int, 3> facet : mesh.facets) {
    std::sort(facet.begin(), facet.end());
    EXPECT_TRUE(corners.insert(facet).second) << "duplicate";
  }
}

TEST_P(Part4, HasTheSizeAndVolume) {
  const Measures m = measure(part_);
  EXPECT_NEAR(m.volume, want_.volume, want_.volume_tolerance * want_.volume);
  EXPECT_LT(m.longest_edge, want_.longest_edge);
  EXPECT_GT(m.lowest_height, 0.02);  // slivers; 600 float32 steps at 400 mm
  for (const auto& [got, want] : {std::pair{m.low, want_.low}, {m.high, want_.high}}) {
    EXPECT_NEAR(got.x, want.x, 0.1);
    EXPECT_NEAR(got.y, want.y, 0.13);
    EXPECT_NEAR(got.z, want.z, 0.1);
  }
}

TEST_P(Part4, IsFloat32AndTheSameEveryTime) {
  constexpr std::uint64_t kBeyondFloat = (1u << 29) - 1;  // the bits of a double that a float32 has not
  for (const auto& triangle : part_)
    for (const Point<Part>& p : triangle)
      for (const double value : {p.x, p.y, p.z})
        ASSERT_EQ(std::bit_cast<std::uint64_t>(value) & kBeyondFloat, 0u) << value;
  EXPECT_EQ(part_by_name(want_.name).value(), part_);
  EXPECT_EQ(hash_of(part_), want_.hash)
      << "another compiler or CPU gives other bytes: " << std::hex << hash_of(part_);
}

TEST_P(Part4, DoesNotCrossItself) {
  const double cell = 2.0 * want_.longest_edge;
  EXPECT_EQ(count_crossings(part_, cell), 0);
  // The counter does find a corner that is pulled through the part.
  Triangles dented = part_;
  const Point<Part> corner = dented[dented.size() / 4][0];
  Point<Part> far = corner;
  for (const auto& triangle : part_)
    for (const Point<Part>& p : triangle)
      if (distance(p, corner) > distance(far, corner)) far = p;
  for (auto& triangle : dented)
    for (Point<Part>& p : triangle)
      if (p == corner) p = lerp(corner, far, 1.01);
  EXPECT_GT(count_crossings(dented, cell), 0);
}

TEST_P(Part4, AgreesWithTheReferenceFile) {
  std::ifstream file(std::string(SOURCE_DIR "/../shared/models/paper/") + want_.file, std::ios::binary);
  if (!file) return;  // the other cases do without
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  ASSERT_EQ(bytes.size(), 84 + 50 * want_.facets);
  Triangles reference(want_.facets);
  for (std::size_t f = 0; f < reference.size(); ++f) {
    float corners[9];
    std::memcpy(corners, bytes.data() + 84 + 50 * f + 12, sizeof corners);
    for (int i = 0; i < 3; ++i) reference[f][i] = {corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]};
  }
  const Measures got = measure(part_), want = measure(reference);
  EXPECT_NEAR(got.volume, want.volume, 0.01 * want.volume);
  EXPECT_LT(length(got.low - want.low), 0.2);
  EXPECT_LT(length(got.high - want.high), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Paper, Part4, testing::ValuesIn(expected_parts()),
                         [](const auto& part) { return std::string(part.param.name); });

TEST(PartByName, NamesThePartsThatThereAre) {
  const auto part = part_by_name("cube");
  ASSERT_FALSE(part);
  EXPECT_EQ(part.error().code, Code::kUsage);
  EXPECT_NE(part.error().message.find("cube"), std::string::npos);
  EXPECT_NE(part.error().message.find("tyre, pin, sphere or handle"), std::string::npos);
}

}  // namespace
}  // namespace tiltfeed::sim
