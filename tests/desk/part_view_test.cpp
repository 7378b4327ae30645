#include "desk/view/part_view.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include "pathgen/mesh/stl.h"
#include "tests/shapes/box_mesh.h"
#include "tests/texts/zip_text.h"

namespace tiltfeed::desk {
using namespace pathgen;
namespace {

using Facets = std::vector<std::array<Point<Part>, 3>>;
using Corner = std::array<float, 3>;
using Edge = std::array<Corner, 2>;

Facets boxes() {
  const Mesh mesh = box_mesh({{Vec3{0, 0, 0}, Vec3{20, 30, 40}}, {Vec3{50, 0, 0}, Vec3{70, 10, 10}}});
  Facets facets;
  for (const auto& f : mesh.facets)
    facets.push_back({mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]});
  return facets;
}

std::string stl_file(const Facets& facets) {
  const std::string path = ::testing::TempDir() + "part_view_test-" + std::to_string(::getpid()) + ".stl";
  EXPECT_TRUE(write_stl(path, facets));
  return path;
}

Edge edge(const Corner& a, const Corner& b) { return a < b ? Edge{a, b} : Edge{b, a}; }

Corner corner(const float* at) { return {at[0], at[1], at[2]}; }

/// The edges that have not two facets of opposite directions, counted from the corners alone.
std::set<Edge> bad_edges(const std::vector<float>& corners) {
  std::map<Edge, std::vector<bool>> found;
  for (std::size_t i = 0; i < corners.size(); i += 9)
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner a = corner(&corners[i + 3 * k]), b = corner(&corners[i + 3 * ((k + 1) % 3)]);
      found[edge(a, b)].push_back(a < b);
    }
  std::set<Edge> bad;
  for (const auto& [at, ways] : found)
    if (ways.size() != 2 || ways[0] == ways[1]) bad.insert(at);
  return bad;
}

TEST(PartView, has_the_files_facets_in_their_order) {
  const Facets facets = boxes();
  const Result<PartView> view = view_part({stl_file(facets), "inch"});
  ASSERT_TRUE(view) << view.error().message;
  ASSERT_EQ(view->corners.size(), facets.size() * 9);
  for (std::size_t i = 0; i < facets.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_FLOAT_EQ(view->corners[9 * i + 3 * k], static_cast<float>(25.4 * facets[i][k].x));
      EXPECT_FLOAT_EQ(view->corners[9 * i + 3 * k + 2], static_cast<float>(25.4 * facets[i][k].z));
    }
  EXPECT_TRUE(view->edges.empty());
  EXPECT_EQ(view->checked.sides, Sides::kOutward);
}

TEST(PartView, marks_the_edges_that_counting_finds) {
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    Facets facets = boxes();
    for (int i = 0; i < 1 + round % 5; ++i) {
      const std::size_t at = random() % facets.size();
      if (random() % 2)
        facets.erase(facets.begin() + static_cast<std::ptrdiff_t>(at));
      else
        std::swap(facets[at][0], facets[at][1]);
    }
    const Result<PartView> view = view_part({stl_file(facets)});
    ASSERT_TRUE(view) << view.error().message;
    std::set<Edge> marked;
    for (std::size_t i = 0; i < view->edges.size(); i += 6)
      marked.insert(edge(corner(&view->edges[i]), corner(&view->edges[i + 3])));
    EXPECT_EQ(marked, bad_edges(view->corners)) << "round " << round;
    EXPECT_EQ(view->bad_edges, marked.size());
  }
}

TEST(PartView, asks_for_the_unit_of_a_size_that_nobody_means) {
  const auto units = [](double longest, double unit_mm) {
    std::string words;
    for (const StlUnit& unit : likelier_units({{0, 0, 0}, {longest, longest / 2, 0}}, unit_mm))
      words += std::string(unit.word) + " ";
    return words;
  };
  EXPECT_EQ(units(100, 1), "");
  EXPECT_EQ(units(5, 1), "");
  EXPECT_EQ(units(1500, 1), "");
  EXPECT_EQ(units(4, 1), "inch ") << "4 inches, not 4 m";
  EXPECT_EQ(units(0.1, 1), "m ");
  EXPECT_EQ(units(1.2, 1), "inch m ");
  EXPECT_EQ(units(2540, 25.4), "mm ");
  EXPECT_EQ(units(80000, 1000), "mm ");
  EXPECT_EQ(units(1e-6, 1), "");
}

/// Two tetrahedra, one with a red facet and three without a colour, the other green.
std::string two_bodies() {
  std::string red = kMfCorner;
  const std::string first = "v1=\"0\" v2=\"2\" v3=\"1\"";
  red.replace(red.find(first), first.size(), first + " pid=\"9\" p1=\"0\"");
  const std::string text = three_mf_of(mf_model(
      "<basematerials id=\"9\"><base name=\"seal\" displaycolor=\"#FF0000\"/><base name=\"rest\" "
      "displaycolor=\"#00FF00\"/></basematerials>\n<object id=\"1\" name=\"lid\">" +
          red + "</object>\n<object id=\"2\" name=\"box\" pid=\"9\" pindex=\"1\">" + kMfCorner +
          "</object>\n",
      "<item objectid=\"1\"/><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 5 0 0\"/>", "unit=\"inch\""));
  const std::string path = ::testing::TempDir() + "part_view_test-" + std::to_string(::getpid()) + ".3mf";
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

TEST(PartView, draws_the_bodies_that_are_asked_for_and_lists_all) {
  const Result<PartView> all = view_part({two_bodies()}), box = view_part({two_bodies(), "mm", {"box"}});
  ASSERT_TRUE(all && box) << (all ? box : all).error().message;
  EXPECT_EQ(all->model.format, "3MF");
  EXPECT_EQ(all->corners.size(), 72u);
  EXPECT_EQ(box->corners.size(), 36u);
  EXPECT_EQ(box->model.bodies.size(), 2u) << "those that are not drawn are listed, too";
  EXPECT_EQ(box->drawn, (std::vector<bool>{false, true}));
  // The file's numbers are inches; the second is five of them away.
  EXPECT_EQ(*std::min_element(box->corners.begin(), box->corners.end()), 0.0f);
  EXPECT_FLOAT_EQ(*std::max_element(box->corners.begin(), box->corners.end()), 6 * 25.4f);
  const auto colour_of = [](const PartView& view, std::size_t facet) {
    const PartFace& face = view.model.faces[view.face_of[facet]];
    return face.colour ? colour_text(*face.colour) : "";
  };
  int red = 0, green = 0;
  ASSERT_EQ(all->face_of.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i)
    red += colour_of(*all, i) == "#ff0000", green += colour_of(*all, i) == "#00ff00";
  EXPECT_EQ(red, 1);
  EXPECT_EQ(green, 4);
  ASSERT_EQ(box->face_of.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(colour_of(*box, i), "#00ff00") << i;
}

TEST(PartView, says_what_it_cannot_find_and_lists_the_bodies_all_the_same) {
  int listed = 0;
  const auto none = view_part({two_bodies(), "mm", {"cover"}}, [&](const PartModel& model) -> Result<void> {
    listed += static_cast<int>(model.bodies.size());
    return {};
  });
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("\"lid\", \"box\""), std::string::npos) << none.error().message;
  EXPECT_EQ(listed, 2);
  const auto face = view_part({two_bodies(), "mm", {"box"}, {"#ff0000"}});
  ASSERT_TRUE(face);
  ASSERT_EQ(face->warnings.size(), 1u) << "the red face is of the other body";
  EXPECT_NE(face->warnings[0].find("#ff0000"), std::string::npos);
  const auto unit = view_part({two_bodies(), "inch"});
  ASSERT_FALSE(unit);
  EXPECT_NE(unit.error().message.find("states its own"), std::string::npos) << unit.error().message;
}

TEST(PartView, refuses_what_the_reader_refuses) {
  EXPECT_FALSE(view_part({"/nowhere/part.stl"}));
  EXPECT_FALSE(write_part_view({stl_file(boxes()), "furlong"}, ::testing::TempDir()));
  const auto unwritable = write_part_view({stl_file(boxes())}, "/nowhere");
  ASSERT_FALSE(unwritable);
  EXPECT_EQ(unwritable.error().code, Code::kIo);
}

}  // namespace
}  // namespace tiltfeed::desk
