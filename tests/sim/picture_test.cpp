// sim/picture: the PNG is read back; what is in front hides what is behind, and the path has its colours.

#include "sim/picture/picture.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "sim/basics/write_bytes.h"
#include "sim/picture/camera.h"
#include "sim/picture/rasteriser.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> bytes;
  std::array<int, 3> at(int x, int y) const {
    const std::size_t i = (static_cast<std::size_t>(y) * width + x) * 3;
    return {bytes[i], bytes[i + 1], bytes[i + 2]};
  }
  /// Pixels of clearly more red than blue: only cutting moves are.
  int warm() const {
    int count = 0;
    for (std::size_t i = 0; i < bytes.size(); i += 3) count += bytes[i] > bytes[i + 2] + 60 ? 1 : 0;
    return count;
  }
  /// Pixels of clearly more green than red: only rapids are.
  int cold() const {
    int count = 0;
    for (std::size_t i = 0; i < bytes.size(); i += 3) count += bytes[i + 1] > bytes[i] + 50 ? 1 : 0;
    return count;
  }
};

Image read_png(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, path.c_str()));
  image.format = PNG_FORMAT_RGB;
  Image result{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  result.bytes.resize(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, result.bytes.data(), 0, nullptr));
  return result;
}

std::string file_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Mesh plate() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back({i & 1 ? 30.0 : -30.0, i & 2 ? 20.0 : -20.0, i & 4 ? 0.0 : -5.0});
  for (const auto& q : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 4, 6, 2},
                        {1, 3, 7, 5}}) {
    mesh.facets.push_back({q[0], q[1], q[2]});
    mesh.facets.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

/// Passes on a plane at height z, the tool from +z.
ToolPath passes_at(double z) {
  ToolPath path;
  for (int pass = 0; pass < 5; ++pass) {
    const double y = -10.0 + 5.0 * pass;
    path.moves.push_back({{{-20, y, z + 10}, {0, 0, 1}}, MoveKind::kRapid});
    path.moves.push_back({{{-20, y, z}, {0, 0, 1}}, MoveKind::kPlunge});
    for (int i = 1; i <= 20; ++i) path.moves.push_back({{{-20.0 + 2 * i, y, z}, {0, 0, 1}}, MoveKind::kCut});
    path.moves.push_back({{{20, y, z + 10}, {0, 0, 1}}, MoveKind::kRapid});
  }
  return path;
}

/// A file of this test's own: others run beside it.
std::string in_test_folder(const std::string& name) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const auto folder = std::filesystem::path(::testing::TempDir()) / "picture_test" / test->name();
  std::filesystem::create_directories(folder);
  return (folder / name).string();
}

TEST(Picture, HasItsSizePartAndPath) {
  const std::string file = in_test_folder("picture.png");
  PictureOptions options;
  options.width = 640, options.height = 400, options.axes = 5;
  ASSERT_TRUE(draw_part_with_path(plate(), passes_at(0.0), file, options));
  const Image image = read_png(file);
  EXPECT_EQ(image.width, 640);
  EXPECT_EQ(image.height, 400);
  EXPECT_GT(image.at(2, 2)[2], 230);  // background
  EXPECT_GT(image.warm(), 1500);
  EXPECT_GT(image.cold(), 100);
  options.rapids = false;
  ASSERT_TRUE(draw_part_with_path(plate(), passes_at(0.0), file, options));
  EXPECT_EQ(read_png(file).cold(), 0);
}

TEST(Picture, PassesThatAreJoinedAreStillPasses) {
  ToolPath path;
  path.moves.push_back({{{-20, -10, 0}, {0, 0, 1}}, MoveKind::kPlunge});
  for (int pass = 0; pass < 41; ++pass)
    for (int i = 0; i <= 20; ++i) {
      const double x = pass % 2 == 0 ? -20.0 + 2 * i : 20.0 - 2 * i;
      path.moves.push_back({{{x, -10.0 + 0.5 * pass, 0}, {0, 0, 1}}, MoveKind::kCut});
    }
  const std::string file = in_test_folder("joined.png");
  PictureOptions options;
  options.width = 640, options.height = 400, options.axes = 0;
  const auto warm = [&](int passes) {
    options.passes = passes;
    EXPECT_TRUE(draw_part_with_path(plate(), path, file, options));
    return read_png(file).warm();
  };
  EXPECT_LT(5 * warm(4), warm(41));
  EXPECT_EQ(read_png(file).cold(), 0);
}

TEST(Picture, PartHidesThePathBehindIt) {
  const std::string file = in_test_folder("hidden.png");
  PictureOptions options;
  options.width = 640, options.height = 400, options.axes = 0, options.rapids = false;
  ASSERT_TRUE(draw_part_with_path(plate(), passes_at(-4.0), file, options));
  EXPECT_EQ(read_png(file).warm(), 0);
}

TEST(Picture, MarkedFacetsHaveTheirColour) {
  const std::string file = in_test_folder("marked.png");
  PictureOptions options;
  options.width = 320, options.height = 200, options.axes = 0, options.rapids = false;
  const Mesh part = plate();
  const auto violet = [&] {  // more red than green, more blue than red
    const Image image = read_png(file);
    int count = 0;
    for (std::size_t i = 0; i < image.bytes.size(); i += 3)
      count += image.bytes[i] > image.bytes[i + 1] + 50 && image.bytes[i + 2] > image.bytes[i] ? 1 : 0;
    return count;
  };
  ASSERT_TRUE(draw_part_with_path(part, ToolPath{}, file, options));
  EXPECT_EQ(violet(), 0);
  options.marks.assign(part.facets.size(), FacetMark::kUnreached);
  ASSERT_TRUE(draw_part_with_path(part, ToolPath{}, file, options));
  EXPECT_GT(violet(), 2000);
  options.marks.pop_back();
  EXPECT_FALSE(draw_part_with_path(part, ToolPath{}, file, options));
}

TEST(Picture, SameInputSameBytes) {
  const std::string a = in_test_folder("a.png"), b = in_test_folder("b.png");
  PictureOptions options;
  options.width = 320, options.height = 200;
  ASSERT_TRUE(draw_part_with_path(plate(), passes_at(0.0), a, options));
  ASSERT_TRUE(draw_part_with_path(plate(), passes_at(0.0), b, options));
  EXPECT_EQ(file_bytes(a), file_bytes(b));
}

TEST(Picture, WithoutPathOrFromAllRound) {
  const std::string file = in_test_folder("bare.png");
  PictureOptions options;
  options.width = 320, options.height = 200;
  EXPECT_TRUE(draw_part_with_path(plate(), ToolPath{}, file, options));
  ToolPath round;
  for (int i = 0; i <= 72; ++i) {
    const double turn = 2.0 * kPi * i / 72;
    const Vec3 axis{0, std::cos(turn), std::sin(turn)};
    round.moves.push_back({{Point<Part>{} + axis * 35.0, axis}, i == 0 ? MoveKind::kRapid : MoveKind::kCut});
  }
  ASSERT_TRUE(draw_part_with_path(plate(), round, file, options));
  EXPECT_GT(read_png(file).warm(), 100);
}

TEST(Picture, ErrorsNameTheFile) {
  const auto empty = draw_part_with_path(Mesh{}, ToolPath{}, "x.png");
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, Code::kInput);
  const auto nowhere = draw_part_with_path(plate(), ToolPath{}, in_test_folder("no/such/folder.png"));
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, Code::kIo);
  EXPECT_NE(nowhere.error().message.find("folder.png"), std::string::npos);
}

TEST(Camera, SeesEverythingAndDepthGrowsAway) {
  const Mesh part = plate();
  const ToolPath path = passes_at(0.0);
  const Camera camera(part, path, 1600, 1000);
  EXPECT_NEAR(dot(camera.eye(), camera.right()), 0.0, 1e-12);
  EXPECT_NEAR(dot(camera.eye(), camera.up()), 0.0, 1e-12);
  EXPECT_NEAR(dot(cross(camera.right(), camera.up()), camera.eye()), 1.0, 1e-12);
  EXPECT_GT(camera.eye().z, 0.5);  // from where the tool comes
  for (const Point<Part> p : part.vertices) {
    const ScreenPoint s = camera.project(p);
    EXPECT_GE(s.x, 0.0);
    EXPECT_LE(s.x, 1600.0);
    EXPECT_GE(s.y, 0.0);
    EXPECT_LE(s.y, 1000.0);
    EXPECT_LT(camera.project(p + camera.eye()).depth, s.depth);
  }
}

/// Read back from a file.
Image seen(const Result<std::string>& png) {
  const std::string file = in_test_folder("raster.png");
  EXPECT_TRUE(png && write_bytes(file, *png));
  return read_png(file);
}

TEST(Rasteriser, NearerTriangleWinsInAnyOrder) {
  const std::array<ScreenPoint, 3> near{ScreenPoint{0, 0, 1}, ScreenPoint{64, 0, 1}, ScreenPoint{0, 64, 1}},
      far{ScreenPoint{0, 0, 2}, ScreenPoint{64, 0, 2}, ScreenPoint{0, 64, 2}};
  const Colour red{1, 0, 0}, blue{0, 0, 1}, black{};
  for (const bool near_first : {true, false}) {
    Rasteriser raster(64, 64, {black, black});
    const auto all = [](Colour colour) { return [colour] { return std::array{colour, colour, colour}; }; };
    if (near_first) raster.triangle(near, all(red));
    raster.triangle(far, all(blue));
    if (!near_first) raster.triangle(near, all(red));
    raster.line({0, 8, 1.5}, {64, 8, 1.5}, 4, {0, 1, 0}, 1.0, 0.0);    // behind: only right of the triangle
    raster.line({0, 20, 1.5}, {64, 20, 1.5}, 4, {0, 1, 0}, 1.0, 1.0);  // the bias brings it to the front
    const Image image = seen(raster.png(1));
    EXPECT_EQ(image.at(4, 40), (std::array<int, 3>{255, 0, 0}));
    EXPECT_EQ(image.at(4, 8), (std::array<int, 3>{255, 0, 0}));
    EXPECT_EQ(image.at(62, 8), (std::array<int, 3>{0, 255, 0}));
    EXPECT_EQ(image.at(4, 20), (std::array<int, 3>{0, 255, 0}));
    EXPECT_EQ(image.at(60, 60), (std::array<int, 3>{0, 0, 0}));
  }
}

TEST(Rasteriser, PixelsTakeTheColourOfWhoeverIsSeenThere) {
  const auto across = [](double left, double right, double depth) {  // covers rows 0 to 8 of these columns
    return std::array{ScreenPoint{left, -8, depth}, ScreenPoint{right, -8, depth},
                      ScreenPoint{0.5 * (left + right), 1000, depth}};
  };
  Rasteriser raster(32, 8, {Colour{1, 0, 0}, Colour{1, 0, 0}});
  const auto white = [] { return Colour{1, 1, 1}; };
  raster.triangle(across(0, 24, 2), 0, white);
  raster.triangle(across(8, 16, 1), 1, white);
  raster.triangle(across(0, 24, 3), 2, [&] {
    ADD_FAILURE() << "it is hidden";
    return white();
  });
  raster.disc({20, 4, 2}, 2.0, {0, 0, 1}, 1.0);
  const Image image = seen(raster.png(1, {{0, 1, 0}, {0, 0, 0}, {1, 1, 1}}, 2));
  EXPECT_EQ(image.at(4, 4), (std::array<int, 3>{0, 255, 0}));
  EXPECT_EQ(image.at(12, 4), (std::array<int, 3>{0, 0, 0}));
  EXPECT_EQ(image.at(20, 4), (std::array<int, 3>{0, 0, 255}));
  EXPECT_EQ(image.at(22, 4), (std::array<int, 3>{0, 255, 0}));
  EXPECT_EQ(image.at(28, 4), (std::array<int, 3>{255, 0, 0}));
}

/// Places and depths at which triangles meet, pass and hide each other, some of them thin.
std::vector<std::array<ScreenPoint, 3>> many_triangles(int side) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-8.0, side + 8.0), near(-3.0, 3.0), depth(-2.0, 2.0);
  std::vector<std::array<ScreenPoint, 3>> triangles;
  for (int i = 0; i < 300; ++i) {
    const double x = place(random), y = place(random);
    std::array<ScreenPoint, 3> corners;
    for (ScreenPoint& p : corners)
      p = i % 10 == 0 ? ScreenPoint{place(random), place(random), depth(random)}
                      : ScreenPoint{x + near(random), y + near(random), depth(random)};
    triangles.push_back(corners);
  }
  return triangles;
}

TEST(Rasteriser, EveryPixelShowsTheTriangleThatIsNearestAtItsMiddle) {
  constexpr int kSide = 48;
  const auto triangles = many_triangles(kSide);
  const auto grey = [](std::size_t i) { return static_cast<double>(i + 1) / 400.0; };
  Rasteriser raster(kSide, kSide, {Colour{}, Colour{}}), owned(kSide, kSide, {Colour{}, Colour{}});
  std::vector<Colour> by_owner;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Colour colour{grey(i), grey(i), grey(i)};
    raster.triangle(triangles[i], [&] { return std::array{colour, colour, colour}; });
    owned.triangle(triangles[i], static_cast<std::uint32_t>(i), [] { return Colour{1, 1, 1}; });
    by_owner.push_back(colour);
  }
  const Image image = seen(raster.png(1)), of_owners = seen(owned.png(1, by_owner));
  EXPECT_EQ(image.bytes, of_owners.bytes);
  int compared = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      double nearest = 1e9, expected = 0.0;
      bool close = false;  // to an edge, or to a triangle behind: rounding may decide
      for (std::size_t i = 0; i < triangles.size(); ++i) {
        // The place as a sum of the corners, by Cramer's rule on (1, x, y).
        const auto& [p, q, r] = triangles[i];
        const auto minor = [](ScreenPoint a, ScreenPoint b, ScreenPoint c) {
          return a.x * (b.y - c.y) + b.x * (c.y - a.y) + c.x * (a.y - b.y);
        };
        const ScreenPoint at{x + 0.5, y + 0.5, 0.0};
        const double whole = minor(p, q, r);
        const double a = minor(at, q, r) / whole, b = minor(p, at, r) / whole, c = minor(p, q, at) / whole;
        const double least = std::min({a, b, c}), depth = a * p.depth + b * q.depth + c * r.depth;
        close |= std::abs(least) < 1e-9 || (least > 0.0 && std::abs(depth - nearest) < 1e-5);
        if (least < 0.0 || depth >= nearest) continue;
        nearest = depth, expected = grey(i);
      }
      if (close) continue;
      ++compared;
      const double s = expected <= 0.0031308 ? 12.92 * expected : 1.055 * std::pow(expected, 1 / 2.4) - 0.055;
      EXPECT_NEAR(image.at(x, y)[0], s * 255.0, 0.51) << x << " " << y;
    }
  }
  EXPECT_GT(compared, kSide * kSide * 9 / 10);
}

TEST(Rasteriser, HollowsAreShadedByWhatIsRoundThem) {
  constexpr int kSide = 40;
  const auto plane = [&](double left, double right, double depth) {
    const auto white = [] { return std::array{Colour{1, 1, 1}, Colour{1, 1, 1}, Colour{1, 1, 1}}; };
    return std::pair{std::array{ScreenPoint{left, -1, depth}, ScreenPoint{right, -1, depth},
                                ScreenPoint{right, 5.0 * kSide, depth}},
                     white};
  };
  // A groove, 8 px wide and as deep as counts; nothing on the left of 6.
  Rasteriser raster(kSide, kSide, {Colour{1, 1, 1}, Colour{1, 1, 1}});
  for (const auto& [left, right, depth] :
       {std::array{6.0, 16.0, 0.0}, {16.0, 24.0, 1.0}, {24.0, 60.0, 0.0}}) {
    const auto [corners, white] = plane(left, right, depth);
    raster.triangle(corners, white);
    raster.triangle({corners[0], corners[2], ScreenPoint{left, 5.0 * kSide, depth}}, white);
  }
  raster.shade_hollows(6.0, 1.0, 0.5);
  const Image image = seen(raster.png(1));
  EXPECT_EQ(image.at(2, 20)[0], 255);   // background
  EXPECT_EQ(image.at(34, 20)[0], 255);  // flat, and at the picture's edge
  EXPECT_EQ(image.at(39, 39)[0], 255);
  EXPECT_EQ(image.at(9, 20)[0], 255);  // an outer edge is no hollow
  EXPECT_LT(image.at(20, 20)[0], 235);
  EXPECT_LT(image.at(17, 20)[0], 235);  // on one side only, at a wall
  EXPECT_LT(image.at(20, 39)[0], 235);
  EXPECT_LT(image.at(20, 0)[0], 235);
  // A slope is none either, away from the picture's edge.
  Rasteriser slope(kSide, kSide, {Colour{1, 1, 1}, Colour{1, 1, 1}});
  slope.triangle({ScreenPoint{-1, -1, 0}, ScreenPoint{5.0 * kSide, -1, 40}, ScreenPoint{-1, 5.0 * kSide, 20}},
                 [] {
                   return std::array{Colour{1, 1, 1}, Colour{1, 1, 1}, Colour{1, 1, 1}};
                 });
  slope.shade_hollows(6.0, 1.0, 0.5);
  const Image even = seen(slope.png(1));
  for (int y = 7; y < kSide - 7; ++y)
    for (int x = 7; x < kSide - 7; ++x) EXPECT_EQ(even.at(x, y)[0], 255) << x << " " << y;
}

TEST(Rasteriser, DiscsAndLinesCoverWhatIsWithinHalfTheirThickness) {
  constexpr int kSide = 40;
  const ScreenPoint from{10.25, 12.5, 0}, to{28.0, 21.75, 0};
  Rasteriser disc(kSide, kSide, {Colour{}, Colour{}}), line(kSide, kSide, {Colour{}, Colour{}});
  disc.disc(from, 13.0, {1, 1, 1}, 0.0);
  line.line(from, to, 5.0, {1, 1, 1}, 1.0, 0.0);
  const Image round = seen(disc.png(1)), band = seen(line.png(1));
  const double dx = to.x - from.x, dy = to.y - from.y, whole = std::hypot(dx, dy);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double px = x + 0.5 - from.x, py = y + 0.5 - from.y, along = (px * dx + py * dy) / whole;
      EXPECT_EQ(round.at(x, y)[0], std::hypot(px, py) <= 6.5 ? 255 : 0) << x << " " << y;
      // Round at its begin, and cut off at its end, where the next one begins.
      const double off = along < 0.0 ? std::hypot(px, py) : std::abs(px * dy - py * dx) / whole;
      EXPECT_EQ(band.at(x, y)[0], off <= 2.5 && along < whole ? 255 : 0) << x << " " << y;
    }
  }
}

}  // namespace
}  // namespace tiltfeed::sim
