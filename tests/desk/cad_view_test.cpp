// STEP and IGES as the page draws them: the facets that the planner has, faces by name and colour.

#include <gtest/gtest.h>

#include "config/part_reading.h"
#include "desk/view/part_view.h"
#include "tests/cad/made_files.h"

namespace tiltfeed::desk {
namespace {

/// Bit by bit: reach maps and pictures name facets by their number.
TEST(CadView, draws_the_facets_that_the_planner_reads) {
  const std::string file = cad_file("assembly.step");
  for (const std::vector<std::string>& bodies : {std::vector<std::string>{}, {"knob"}, {"block"}}) {
    const auto view = view_part({file, "mm", bodies, {}, 0.05});
    const auto read = config::read_part_file({file, 1.0, bodies, 0.05});
    ASSERT_TRUE(view.has_value()) << view.error().message;
    ASSERT_TRUE(read.has_value()) << read.error().message;
    ASSERT_EQ(view->corners.size(), read->mesh.facets.size() * 9);
    for (std::size_t i = 0; i < read->mesh.facets.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const Point<Part> at = read->mesh.facets[i][k];
        ASSERT_EQ(view->corners[9 * i + 3 * k], static_cast<float>(at.x)) << i;
        ASSERT_EQ(view->corners[9 * i + 3 * k + 2], static_cast<float>(at.z)) << i;
      }
    for (std::size_t i = 0; i < read->face_of.size(); ++i)
      ASSERT_EQ(view->model.faces[view->face_of[i]].entity, read->faces[read->face_of[i]].entity);
    EXPECT_EQ(view->model.bodies.size(), 3u);
  }
}

TEST(CadView, a_file_that_cannot_be_read_is_refused_in_words) {
  const auto none = view_part({"/nowhere/part.step"});
  ASSERT_FALSE(none.has_value());
  const auto body = view_part({cad_file("assembly.step"), "mm", {"lid"}, {}, 0.05});
  ASSERT_FALSE(body.has_value());
  EXPECT_NE(body.error().message.find("no body has the name \"lid\""), std::string::npos)
      << body.error().message;
}

}  // namespace
}  // namespace tiltfeed::desk
