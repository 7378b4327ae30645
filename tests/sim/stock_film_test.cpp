// The stock's film against the stock itself, and the viewer's packing read back.

#include <zlib.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/viewer/packed_view.h"
#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
namespace {

/// Ends of a bundle's lines: (two coordinates) -> lowest, highest.
std::map<std::pair<long, long>, std::array<double, 2>> ends(const Dexels& lines) {
  std::map<std::pair<long, long>, std::array<double, 2>> all;
  for (int stripe = 0; stripe < Dexels::kStripes; ++stripe)
    lines.each(stripe, [&](Point<Part> o, double low, double high) {
      const auto key = std::pair(std::lround(o.x * 1000.0), std::lround(o.y * 1000.0));
      const auto [at, fresh] = all.try_emplace(key, std::array{low, high});
      if (!fresh) at->second = {std::min(at->second[0], low), std::max(at->second[1], high)};
    });
  return all;
}

// (removal.h, property 5)
TEST(StockFilm, BeginsWithTheStockAndEndsWithWhatIsLeft) {
  Shop shop;
  std::string text;
  for (const std::string& line : shop.lines) text += line + "\n";
  std::istringstream in(text);
  const auto path =
      execute_program(*read_program(in, "p.nc", 'A', 'C'), "p.nc", shop.job.machine.model, shop.job.setup);
  const double cell = 0.5;
  auto stock = make_stock(*parse_stock("box:1"), shop.part, shop.job, cell, 2, {2});
  auto lines = make_stock(*parse_stock("box:1"), shop.part, shop.job, cell, 2, {2});
  ASSERT_TRUE(stock && lines);
  const auto before = ends(stock->bundles[0]);
  StockFilm film(std::move(lines->bundles[0]), cell, path->moves.front().start, path->moves.back().end);
  Probes probes(shop.part.mesh, 0.5, 0.5);
  ASSERT_TRUE(remove_material(shop.job, *path, *stock, probes, {}, {}, &film));
  const auto after = ends(stock->bundles[0]);
  ASSERT_EQ(film.frames().size(), StockFilm::kFrames);
  const std::size_t count = std::size_t{film.size()[0]} * film.size()[1];
  ASSERT_EQ(count, before.size());
  const double unit = (film.span()[1] - film.span()[0]) / 65534.0;
  std::size_t cut = 0;
  for (const auto& [key, end] : before) {
    const auto u = static_cast<std::size_t>(
                   std::lround((static_cast<double>(key.first) / 1000.0 - film.first()[0]) / cell)),
               v = static_cast<std::size_t>(
                   std::lround((static_cast<double>(key.second) / 1000.0 - film.first()[1]) / cell));
    const std::size_t at = v * film.size()[0] + u;
    const auto top = [&](std::size_t frame) {
      return film.span()[0] + (film.frames()[frame][at] - 1) * unit;
    };
    EXPECT_NEAR(top(0), end[1], unit);
    EXPECT_NEAR(film.span()[0] + (film.frames()[0][count + at] - 1) * unit, end[0], unit);
    const auto left = after.find(key);
    if (left == after.end())
      EXPECT_EQ(film.frames().back()[at], StockFilm::kNothing);
    else
      EXPECT_NEAR(top(StockFilm::kFrames - 1), left->second[1], unit);
    for (std::size_t f = 1; f < StockFilm::kFrames; ++f)
      EXPECT_LE(film.frames()[f][at], film.frames()[f - 1][at]);
    if (film.frames().back()[at] < film.frames()[0][at]) ++cut;
  }
  EXPECT_GT(cut, count / 4);
  // It is cut bit by bit, not all at once.
  std::size_t changed = 0;
  for (std::size_t f = 1; f < StockFilm::kFrames; ++f) changed += film.frames()[f] != film.frames()[f - 1];
  EXPECT_GT(changed, StockFilm::kFrames / 2);
}

TEST(PackedView, IsReadBackByItsHead) {
  PackedView view;
  const std::vector<float> floats{1.5F, -2.0F, 1e6F};
  const std::vector<std::int16_t> shorts{-32768, 7, 32767};
  const std::vector<std::uint32_t> numbers{5, 3, 4'000'000'000U, 0};
  view.add("floats", std::span<const float>(floats));
  view.add("shorts", std::span<const std::int16_t>(shorts));
  view.add_steps("numbers", numbers);
  const std::string bytes = unzipped(view.packed("\"name\": \"x\""));
  std::uint32_t length = 0;
  ASSERT_GT(bytes.size(), sizeof length);
  std::memcpy(&length, bytes.data(), sizeof length);
  EXPECT_EQ(length % 4, 0u);
  const auto head = nlohmann::json::parse(bytes.substr(4, length));
  EXPECT_EQ(head["name"], "x");
  const auto at = [&](const char* name) {
    return bytes.data() + 4 + length + head["arrays"][name]["at"].get<std::size_t>();
  };
  EXPECT_EQ(std::memcmp(at("floats"), floats.data(), 12), 0);
  EXPECT_EQ(std::memcmp(at("shorts"), shorts.data(), 6), 0);
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::uint32_t step = 0;
    std::memcpy(&step, at("numbers") + 4 * i, 4);
    EXPECT_EQ(sum += step, numbers[i]);
  }
  EXPECT_EQ(unzipped("no gzip"), "");
  EXPECT_EQ(base64("any carnal pleas"), "YW55IGNhcm5hbCBwbGVhcw==");
}

}  // namespace
}  // namespace tiltfeed::sim
