// The worst places of a removal run: feeds that are too fast, where most is left, and the lines they are
// linked to.

#include <fstream>
#include <iterator>

#include "sim/report/report_page.h"
#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

// Of the Shop's program: a rapid, a plunge, 24 cuts, a rapid.
constexpr std::size_t kRowLines = 27;

std::size_t first_line(std::size_t row) { return 1 + row * kRowLines; }

TEST(RemovalPlaces, AFeedThatIsTooFastIsARow) {
  Shop shop;
  const double feed = shop.time_by_tip();
  shop.job.plan.cut_feed = shop.job.plan.plunge_feed = Feed::from_mm_per_min(feed);
  const std::size_t bad = shop.cuts[100];
  shop.lines.erase(shop.lines.begin() + static_cast<std::ptrdiff_t>(bad));
  const auto [removal, verdict] = shop.run(0.5);
  EXPECT_FALSE(verdict.passed());
  const std::vector<WorstPlace> places = worst_places(removal, verdict);
  ASSERT_FALSE(places.empty());
  EXPECT_TRUE(places[0].wrong);
  EXPECT_EQ(places[0].what.find("feed too fast: 20"), 0u) << places[0].what;  // twice the job's 1000
  EXPECT_EQ(places[0].line, Shop::number(bad));
  // The tip is where the line after the missing one ends; the blocks before it take 0.5 mm a 0.03 s each.
  EXPECT_LT(distance(places[0].place, shop.poses[bad].tip), 1e-3);
  EXPECT_GT(places[0].time, 0.0);
  const StockShape shape = *parse_stock("box");
  const RemovalContext context{shop.job, shop.part, shape, "p.nc", {}};
  const std::vector<ColourStop> scale;
  const std::string html = places_html({context, removal, verdict, scale, "", "", {}});
  EXPECT_NE(html.find("feed too fast"), std::string::npos) << html;
}

TEST(RemovalPlaces, MostIsLeftBetweenRowsThatAreFarApart) {
  Shop shop;
  // Of the top nothing is beyond the rows; four of them are left out, so that two are 2 mm apart.
  shop.part = checked(box_mesh({{Vec3{-5.9, -3.1, -6}, Vec3{5.9, 3.1, 0}}}));
  constexpr std::size_t kMissing = 7, kCount = 4;
  const auto at = [&](std::size_t row) {
    return shop.lines.begin() + static_cast<std::ptrdiff_t>(first_line(row));
  };
  shop.lines.erase(at(kMissing), at(kMissing + kCount));
  const auto [removal, verdict] = shop.run(0.05);
  ASSERT_GE(removal.most_left.size(), 2u);
  const double ridge = kRadius - std::sqrt(kRadius * kRadius - 1.0);
  const Leftover& most = removal.most_left[0];
  EXPECT_NEAR(most.left, ridge, 0.02);
  EXPECT_NEAR(most.place.y, 0.4, 0.05);
  EXPECT_NEAR(most.place.z, 0.0, 1e-9);
  EXPECT_TRUE(most.facet == 2 || most.facet == 3 || most.facet == 1002 || most.facet == 1003) << most.facet;
  EXPECT_GE(most.line, first_line(kMissing - 1));
  EXPECT_LE(most.line, first_line(kMissing + 1));
  for (std::size_t i = 1; i < removal.most_left.size(); ++i) {
    EXPECT_LE(removal.most_left[i].left, removal.most_left[i - 1].left);
    EXPECT_GE(distance(removal.most_left[i].place, most.place), 3.9 * kRadius);
  }
  EXPECT_NE(shop.json.find("\"most_left\""), std::string::npos);
  // Told, not judged: ridges of what the job asks for are no row.
  std::size_t rows = 0;
  for (const WorstPlace& w : worst_places(removal, verdict)) {
    rows += w.wrong ? 0 : 1;
    EXPECT_EQ(w.what.find("material left"), 0u);
  }
  std::size_t above = 0;
  for (const Leftover& l : removal.most_left) above += l.left > verdict.excess_limit ? 1 : 0;
  EXPECT_EQ(rows, above);
  EXPECT_GT(rows, 0u);
}

TEST(RemovalPlaces, LinesRoundAPlaceAreTheSources) {
  Shop shop;
  // Numbers of lines and of blocks differ.
  shop.lines.insert(shop.lines.begin() + 1, {"(one)", "(two)", "(three)"});
  shift(shop.lines[shop.cuts[100] + 3], 'Z', -0.2);
  std::string text;
  for (const std::string& line : shop.lines) text += line + "\n";
  std::istringstream in(text);
  const auto path =
      execute_program(*read_program(in, "p.nc", 'A', 'C'), "p.nc", shop.job.machine.model, shop.job.setup);
  const auto shape = parse_stock("offset:0.5");
  auto stock = make_stock(*shape, shop.part, shop.job, 0.5, 2);
  Probes probes(shop.part.mesh, 0.5, 0.5);
  const auto cut = remove_material(shop.job, *path, *stock, probes, {}, {});
  ASSERT_FALSE(cut->troubles.empty());
  const std::string folder = BINARY_DIR "/removal_places", source = folder + ".txt";
  ASSERT_TRUE(make_report_folder(folder));
  const Drawings drawings = draw_report(shop.job, shop.part, *path, probes.patches());
  const auto marked = [&](Source kind, const std::string& bytes) {
    std::ofstream(source, std::ios::trunc) << bytes;
    const RemovalContext context{shop.job, shop.part, *shape, source, {}, kind};
    const RemovalVerdict verdict = judge(*cut, context);
    EXPECT_TRUE(write_removal_report(folder, {context, drawings, *cut, verdict, *path, probes, nullptr}, 2));
    std::ifstream page(folder + "/index.html");
    const std::string html{std::istreambuf_iterator<char>(page), {}};
    const std::size_t from = html.find("<mark>") + 6;
    return html.substr(from, html.find("</mark>") - from);
  };
  const Trouble& worst = cut->troubles[0];
  ASSERT_NE(worst.block, worst.line);
  std::string trace = "block,line,op\n", canon;
  for (std::size_t n = 1; n < 900; ++n) {
    trace += std::to_string(n) + "," + std::to_string(n + 3) + ",feed\n";
    canon += "    " + std::to_string(n + 7) + " N..... STRAIGHT_FEED\n";
  }
  EXPECT_EQ(marked(Source::kProgram, text), shop.lines[worst.line - 1]);
  EXPECT_EQ(marked(Source::kTrace, trace),
            std::to_string(worst.block) + "," + std::to_string(worst.block + 3) + ",feed");
  EXPECT_EQ(marked(Source::kCanon, canon), "    " + std::to_string(worst.line) + " N..... STRAIGHT_FEED");
}

}  // namespace
}  // namespace tiltfeed::sim
