// OBJ and PLY: the same solid from every form, by texts and bytes that the test writes itself.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

Result<Stl> parse(const std::string& bytes, double unit_mm = 1.0) {
  return parse_stl(bytes, "part", unit_mm);
}

/// A box of 2 by 3 by 4 at (1, 0, 0): eight corners, six faces of four.
constexpr double kCorners[8][3] = {{1, 0, 0}, {3, 0, 0}, {3, 3, 0}, {1, 3, 0},
                                   {1, 0, 4}, {3, 0, 4}, {3, 3, 4}, {1, 3, 4}};
constexpr int kFaces[6][4] = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4},
                              {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

std::string obj_box() {
  std::string text = "# a box\nmtllib none.mtl\no Box\n";
  for (const auto& c : kCorners)
    text +=
        "v " + std::to_string(c[0]) + " " + std::to_string(c[1]) + " \\\n " + std::to_string(c[2]) + " 1.0\n";
  text += "vn 0 0 1\nvt 0 0\r\n";
  const char* const kinds[] = {"", "/1", "//1", "/1/1"};
  for (int i = 0; i < 6; ++i) {
    text += "g side" + std::to_string(i) + "\nf";
    // Every other face counts backwards.
    for (const int corner : kFaces[i])
      text += " " + std::to_string(i % 2 == 0 ? corner + 1 : corner - 8) + kinds[i % 4];
    text += "  # a side\n";
  }
  return text + "l 1 2\n";
}

template <class T>
void put(std::string& out, T value, bool big) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  if (big) std::reverse(bytes, bytes + sizeof value);
  out.append(bytes, sizeof value);
}

std::string ply_header(const std::string& format, const std::string& real) {
  return "ply\nformat " + format + " 1.0\ncomment a box\nelement vertex 8\nproperty uchar red\nproperty " +
         real + " x\nproperty " + real + " y\nproperty " + real +
         " z\nelement face 6\nproperty list uchar int vertex_indices\nproperty list ushort float weights\n"
         "element edge 1\nproperty int a\nend_header\n";
}

std::string ply_box(const std::string& format) {
  std::string out = ply_header(format, format == "ascii" ? "float" : "double");
  const bool text = format == "ascii", big = format == "binary_big_endian";
  const auto number = [&](auto value) {
    if (text)
      out += std::to_string(value) + " ";
    else
      put(out, value, big);
  };
  for (const auto& c : kCorners) {
    number(std::uint8_t{200});
    for (const double x : c) number(x);
  }
  for (const auto& face : kFaces) {
    number(std::uint8_t{4});
    for (const int corner : face) number(std::int32_t{corner});
    number(std::uint16_t{1});
    number(0.5F);
  }
  number(std::int32_t{7});
  return out;
}

void expect_box(const std::string& bytes) {
  const auto stl = parse(bytes);
  ASSERT_TRUE(stl.has_value()) << stl.error().message;
  EXPECT_EQ(stl->facets.size(), 12u);
  const auto checked = check_mesh(*stl);
  ASSERT_TRUE(checked.has_value()) << checked.error().message;
  EXPECT_TRUE(checked->defects.empty());
  EXPECT_EQ(checked->sides, Sides::kOutward);
  EXPECT_NEAR(checked->volume, 24.0, 1e-9);
  EXPECT_EQ(checked->bounds.min.x, 1.0);
  EXPECT_EQ(checked->bounds.max.z, 4.0);
  const auto inches = parse(bytes, 25.4);
  ASSERT_TRUE(inches.has_value());
  EXPECT_EQ(inches->facets[5][2].y, 25.4 * stl->facets[5][2].y);
}

TEST(MeshFormats, EachFormIsTheSameBox) {
  for (const std::string& bytes :
       {obj_box(), ply_box("ascii"), ply_box("binary_little_endian"), ply_box("binary_big_endian")}) {
    SCOPED_TRACE(bytes.substr(0, 40));
    expect_box(bytes);
  }
  EXPECT_EQ(parse(obj_box())->warnings,
            std::vector<std::string>{"part: 1 lines and points without a surface are ignored"});
  EXPECT_EQ(parse(ply_box("ascii") + "8")->warnings.size(), 1u);
}

/// Faces of many corners keep their area, wherever a hollow starts; what no corner sees whole is refused.
TEST(MeshFormats, CutsUpFacesOfManyCorners) {
  const auto area = [](const std::string& corners, const std::string& face) -> Result<double> {
    const auto stl = parse(corners + "f " + face + "\n");
    if (!stl) return tl::unexpected(stl.error());
    double sum = 0.0;
    for (const auto& f : stl->facets) sum += 0.5 * cross(f[1] - f[0], f[2] - f[0]).z;
    return sum;
  };
  const std::string arrow = "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\n";  // hollow at (1, 1)
  for (const char* face : {"1 2 3 4", "2 3 4 1", "3 4 1 2", "4 1 2 3"}) {
    const auto found = area(arrow, face);
    ASSERT_TRUE(found.has_value()) << found.error().message;
    EXPECT_NEAR(*found, 4.0, 1e-12) << face;
    EXPECT_EQ(parse(arrow + "f " + face + "\n")->facets.size(), 2u);
  }
  // A comb: no corner sees both teeth.
  const auto comb =
      area("v 0 0 0\nv 5 0 0\nv 5 3 0\nv 4 3 0\nv 4 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n", "1 2 3 4 5 6 7 8");
  ASSERT_FALSE(comb.has_value());
  EXPECT_EQ(comb.error().code, Code::kMesh);
  EXPECT_EQ(comb.error().message,
            "part: line 9: a face of 8 corners that is not convex; export the part as triangles");
  const auto bent = parse("v 0 0 0\nv 4 0 0\nv 4 4 0.1\nv 0 4 0\nf 1 2 3 4\n", 10.0);
  ASSERT_TRUE(bent.has_value());
  ASSERT_EQ(bent->warnings.size(), 1u);
  EXPECT_NE(bent->warnings[0].find("1 faces are not flat, by up to "), std::string::npos)
      << bent->warnings[0];
}

TEST(MeshFormats, SaysWhereAFileIsWrong) {
  const auto says = [](const std::string& bytes, const std::string& what) {
    const auto stl = parse(bytes);
    ASSERT_FALSE(stl.has_value()) << bytes;
    EXPECT_NE(stl.error().message.find(what), std::string::npos) << stl.error().message;
  };
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  says(corners + "f 1 2 4\n", "line 4: corner 4 of the 3");
  says(corners + "f 1 2 -4\n", "line 4: corner -4 of the 3");
  says(corners + "f 1 2 0\n", "line 4: \"0\" is no corner of a face");
  says(corners + "f 1 2\n", "line 4: a face of 2 corners");
  says(corners, "no faces, only 3 points");
  says("v 0 0\n", "line 1: a corner needs three coordinates");
  says("v 0,5 0 0\n", "line 1: \"0,5\" is not a number; write decimals with a point");
  says(corners + "cstype bspline\n", "line 4: cstype: free-form curves and surfaces cannot be read");
  says(corners + "fish 1 2 3\n", "line 4: \"fish\" begins no statement of OBJ");
  says("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "NaN or infinite");
  says("v 1e9 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "beyond the limit");
  const std::string ply = ply_box("binary_little_endian");
  says(ply.substr(0, ply.size() - 100), "face 1 of 6, weights: the file is cut short");
  says(ply.substr(0, 20), "the header has no end_header");
  says("ply\nformat binary 1.0\nend_header\n", "line 2: format \"binary\"");
  says("ply\nformat ascii 1.0\nelement tristrips 3\nend_header\n", "line 3: tristrips");
  says("ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\nend_header\n", "line 4: ");
  says("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "lacks x, y or z");
  says(
      "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "end_header\n0 0 0\n",
      "vertex 1 of 99999999999, x: the file is cut short");
}

/// Any cut and any changed byte: an error, or facets that are finite.
TEST(MeshFormats, DamageIsAnErrorOrFacets) {
  std::mt19937 dice(3);
  const auto any = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(dice);
  };
  for (const std::string& whole : {obj_box(), ply_box("ascii"), ply_box("binary_little_endian")})
    for (int i = 0; i < 1000; ++i) {
      std::string bytes = whole;
      if (i % 2 == 0) bytes.resize(any(bytes.size()));
      for (std::size_t k = 0; k < any(4) && !bytes.empty(); ++k)
        bytes[any(bytes.size())] = static_cast<char>(any(256));
      const auto stl = parse(bytes);
      if (!stl) continue;
      for (const auto& facet : stl->facets)
        for (const Point<Part> p : facet) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
    }
}

}  // namespace
}  // namespace tiltfeed
