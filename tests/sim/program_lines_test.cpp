// The G-code reader's quick ways, plain lines and a stream read ahead, give what the long ways give.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <streambuf>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "sim/gcode/gcode_reader.h"

namespace tiltfeed::sim {
namespace {

/// Words of all kinds, right and wrong ones, some with more digits than a double keeps.
std::string random_line(std::mt19937& random) {
  const auto pick = [&](std::string_view of) { return of[random() % of.size()]; };
  std::string line;
  for (int words = static_cast<int>(random() % 7); words > 0; --words) {
    line += pick("XYZACFXYZACFGGGMNSTPxyacfgEBQ");
    if (random() % 20 == 0) line += pick(" \t+");
    if (random() % 3 == 0) line += '-';
    const std::size_t whole = random() % 5, decimals = random() % 6;
    const std::size_t more = random() % 10 == 0 ? 5 + random() % 3 : 0;
    for (std::size_t i = 0; i < whole + more; ++i) line += pick("0123456789");
    if (random() % 3 != 0) line += '.';
    for (std::size_t i = 0; i < decimals + more; ++i) line += pick("0123456789");
    if (random() % 30 == 0) line += pick(".-+eE(%$0");
    if (random() % 4 == 0) line += pick(" \t");  // CR ends a line
  }
  return line;
}

// A comment sends a line the long way, by from_chars.
TEST(SimLines, PlainLinesAreReadAsThoseWithAComment) {
  std::mt19937 random(21);
  for (const char axis : {'A', 'E'}) {
    GcodeReader plain = GcodeReader(axis, 'C').with_relative(),
                commented = GcodeReader(axis, 'C').with_relative();
    int good = 0;
    for (int i = 0; i < 100000; ++i) {
      const std::string line = i % 50 == 0 ? "G94 G1 X1 F2" : random_line(random);
      const auto a = plain.read_line(line), b = commented.read_line(line + ";");
      ASSERT_EQ(a.has_value(), b.has_value()) << line;
      if (!a) {
        ASSERT_EQ(a.error().message, b.error().message) << line;
        ASSERT_EQ(plain.fault(), commented.fault()) << line;
        continue;
      }
      ASSERT_EQ(a->size(), b->size()) << line;
      for (std::size_t k = 0; k < a->size(); ++k) {
        const Block &p = (*a)[k], &q = (*b)[k];
        ASSERT_EQ(p.target, q.target) << line;
        ASSERT_EQ(std::signbit(p.target.x), std::signbit(q.target.x)) << line;
        ASSERT_EQ(std::tie(p.op, p.feed, p.inverse_time, p.exact_stop, p.m_code, p.spindle, p.line, p.tool),
                  std::tie(q.op, q.feed, q.inverse_time, q.exact_stop, q.m_code, q.spindle, q.line, q.tool))
            << line;
      }
      ++good;
    }
    EXPECT_GT(good, 10000);
  }
}

/// A stream whose bytes come a few at a time.
class Trickle : public std::streambuf {
 public:
  explicit Trickle(std::string text) : text_(std::move(text)) {}

 protected:
  int_type underflow() override {
    if (at_ >= text_.size()) return traits_type::eof();
    const std::size_t count = std::min(text_.size() - at_, 1 + at_ % 7);
    setg(text_.data() + at_, text_.data() + at_, text_.data() + at_ + count);
    at_ += count;
    return traits_type::to_int_type(*gptr());
  }

 private:
  std::string text_;
  std::size_t at_ = 0;
};

TEST(SimLines, LinesOfAnyLengthAreThoseOfTheText) {
  std::mt19937 random(4);
  for (const std::size_t longest : {0U, 30U, 70000U, 200000U}) {
    for (const char* end : {"", "\n", "\r\n", "\n\n\n"}) {
      std::string text;
      std::vector<double> places;
      std::vector<std::uint32_t> lines;
      std::uint32_t count = 0;
      while (text.size() < 300000) {
        ++count;
        if (random() % 4 == 0) {
          text += "\n";
          continue;
        }
        places.push_back(static_cast<double>(random() % 1000)), lines.push_back(count);
        text += "G0 X" + std::to_string(static_cast<int>(places.back()));
        if (longest > 0) text += "(" + std::string(random() % longest, 'x') + ")";
        text += random() % 2 == 0 ? "\n" : "\r\n";
      }
      text += "G0 X77" + std::string(end);
      places.push_back(77), lines.push_back(count + 1);
      Trickle slow(text);
      std::istringstream at_once(text);
      std::istream trickles(&slow);
      for (std::istream* in : {static_cast<std::istream*>(&at_once), &trickles}) {
        const auto blocks = read_program(*in, "test.nc", GcodeReader('A', 'C'));
        ASSERT_TRUE(blocks) << blocks.error().message;
        ASSERT_EQ(blocks->size(), places.size());
        for (std::size_t i = 0; i < places.size(); ++i) {
          ASSERT_EQ((*blocks)[i].target.x, places[i]);
          ASSERT_EQ((*blocks)[i].line, lines[i]);
        }
      }
    }
  }
  std::istringstream nothing("");
  EXPECT_TRUE(read_program(nothing, "test.nc", GcodeReader('A', 'C'))->empty());
}

}  // namespace
}  // namespace tiltfeed::sim
