#include "pathgen/mesh/stl.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <random>

namespace tiltfeed {
using namespace pathgen;
namespace {

using FloatFacet = std::array<float, 9>;

/// An STL writer of the test's own.
std::string binary(const std::vector<FloatFacet>& facets, const std::string& header = "binary") {
  std::string out = header + std::string(80 - header.size(), '\0');
  const auto append = [&out](const void* data, std::size_t size) {
    out.append(static_cast<const char*>(data), size);
  };
  const auto count = static_cast<std::uint32_t>(facets.size());
  append(&count, 4);
  for (const FloatFacet& f : facets) {
    const float normal[3] = {NAN, INFINITY, 7.0F};  // must not matter
    append(normal, 12);
    append(f.data(), 36);
    append("\x12\x34", 2);
  }
  return out;
}

std::string shortest(float value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string nine_digits(float value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, 8).ptr};
}

/// `space` between words, `line` between lines.
std::string ascii(const std::vector<FloatFacet>& facets, const std::string& space = " ",
                  const std::string& line = "\n", std::string (*number)(float) = shortest) {
  std::string out = "solid some name" + line;
  for (const FloatFacet& f : facets) {
    out += "facet normal 0 0 1" + line + "outer" + space + "loop" + line;
    for (int k = 0; k < 9; k += 3)
      out += "vertex" + space + number(f[k]) + space + number(f[k + 1]) + space + number(f[k + 2]) + line;
    out += "endloop" + line + "endfacet" + line;
  }
  return out + "endsolid some name" + line;
}

std::vector<FloatFacet> random_facets(std::mt19937& random, std::size_t count) {
  std::uniform_real_distribution<float> mantissa(-1.0F, 1.0F);
  std::uniform_int_distribution<int> exponent(-40, 8), pick(0, 15);
  std::vector<FloatFacet> facets(count);
  for (FloatFacet& f : facets) {
    for (float& c : f) {
      const int kind = pick(random);
      c = kind == 0   ? -0.0F
          : kind == 1 ? std::numeric_limits<float>::denorm_min()
          : kind == 2 ? -300.0F
                      : std::ldexp(mantissa(random), exponent(random));
    }
  }
  return facets;
}

/// As bits, so that -0 and 0 differ.
std::vector<std::uint64_t> bits(const Stl& stl) {
  std::vector<std::uint64_t> out;
  for (const auto& f : stl.facets)
    for (const Point<Part>& p : f)
      for (double c : {p.x, p.y, p.z}) out.push_back(std::bit_cast<std::uint64_t>(c));
  return out;
}

const std::vector<FloatFacet> kTwo = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 1, 0, 0, 0, 1.5F}};

void expect_error(const Result<Stl>& stl, Code code, const std::string& piece) {
  ASSERT_FALSE(stl) << "accepted with " << stl->facets.size() << " facets; expected: " << piece;
  EXPECT_EQ(stl.error().code, code) << stl.error().message;
  EXPECT_NE(stl.error().message.find(piece), std::string::npos)
      << stl.error().message << "\nlacks: " << piece;
  EXPECT_EQ(stl.error().message.find('\n'), std::string::npos) << stl.error().message;
}

TEST(Stl, TextEqualsBinary) {
  std::mt19937 random(20);
  for (int round = 0; round < 40; ++round) {
    const std::vector<FloatFacet> facets = random_facets(random, 25);
    for (double unit : {1.0, 25.4}) {
      const Result<Stl> from_binary = parse_stl(binary(facets), "b", unit);
      ASSERT_TRUE(from_binary) << from_binary.error().message;
      EXPECT_TRUE(from_binary->binary);
      ASSERT_EQ(from_binary->facets.size(), facets.size());
      for (std::size_t i = 0; i < facets.size(); ++i)
        ASSERT_EQ(from_binary->facets[i][2].y, static_cast<double>(facets[i][7]) * unit);
      std::string upper = ascii(facets, "  ", "\r\n");
      for (char& c : upper) c = static_cast<char>(std::toupper(c));
      for (const std::string& text :
           {ascii(facets), ascii(facets, "\t ", "\r\n", nine_digits), ascii(facets, " \v", "\r"), upper,
            "\xEF\xBB\xBF\n " + ascii(facets), ascii(facets, "\n", "\n\n \n"),
            ascii(facets, " ", " ") /* all in one line */}) {
        const Result<Stl> from_text = parse_stl(text, "t", unit);
        ASSERT_TRUE(from_text) << from_text.error().message;
        EXPECT_FALSE(from_text->binary);
        ASSERT_EQ(bits(*from_text), bits(*from_binary));
      }
    }
  }
}

TEST(Stl, BinaryIsToldBySizeNotByHeader) {
  const Result<Stl> solid = parse_stl(binary(kTwo, "solid facet normal 0 0 0\n"), "f", 1.0);
  ASSERT_TRUE(solid) << solid.error().message;
  EXPECT_TRUE(solid->binary);
  EXPECT_TRUE(solid->warnings.empty());
  const Result<Stl> trailing = parse_stl(binary(kTwo, "solid") + std::string(49, 'x'), "f", 1.0);
  ASSERT_TRUE(trailing);
  EXPECT_EQ(trailing->facets.size(), 2U);
  ASSERT_EQ(trailing->warnings.size(), 1U);
  EXPECT_NE(trailing->warnings[0].find("49 bytes after the last facet"), std::string::npos);
}

TEST(Stl, EveryTruncationIsAnError) {
  for (const char* header : {"binary", "solid looks like text"}) {
    const std::string bytes = binary(kTwo, header);
    for (std::size_t size = 0; size < bytes.size(); ++size)
      EXPECT_FALSE(parse_stl({bytes.data(), size}, "f", 1.0)) << header << " cut at " << size;
  }
  const std::string text = ascii(kTwo);
  const std::size_t complete = text.rfind("endsolid") + 8;  // the name after it may be missing
  for (std::size_t size = 0; size < complete; ++size)
    EXPECT_FALSE(parse_stl({text.data(), size}, "f", 1.0)) << "text cut at " << size;
  EXPECT_TRUE(parse_stl({text.data(), complete}, "f", 1.0));
}

TEST(Stl, OddTextIsRead) {
  const std::string text =
      "  SOLID facet of a name\n"
      "facet normal +inf -inf weirdvalue\n outer loop foo\n"
      "vertex 1 +2.5 .5\nVerTex 3. -4E0 5e-1\nvertex 1e-50 -0 6\n"
      "endloop foo bar\nendfacet blah\n"
      "facet normal\nouter loop\nvertex 1 2 3 vertex 4 5 6\nvertex\n7\n8\n9\nendloop endfacet\n"
      "endsolid some blah blah\n\nsolid\nendsolid\nsolid x\nfacet normal 0 0 1 outer loop vertex 0 0 0 "
      "vertex 1 0 0 "
      "vertex 0 1 0 endloop endfacet endsolid x\n \x1A\n";
  const Result<Stl> stl = parse_stl(text, "odd.stl", 1.0);
  ASSERT_TRUE(stl) << stl.error().message;
  ASSERT_EQ(stl->facets.size(), 3U);
  EXPECT_EQ(stl->facets[0][0], (Point<Part>{1, 2.5, 0.5}));
  EXPECT_EQ(stl->facets[0][1], (Point<Part>{3, -4, 0.5}));
  EXPECT_EQ(stl->facets[0][2], (Point<Part>{0, 0, 6}));
  EXPECT_EQ(stl->facets[1][2], (Point<Part>{7, 8, 9}));
  ASSERT_EQ(stl->warnings.size(), 2U);
  EXPECT_EQ(stl->warnings[0], "odd.stl:23: text after endsolid is ignored");
  EXPECT_EQ(stl->warnings[1], "odd.stl: 3 solids are read as one part");
}

TEST(Stl, BadFilesAreRefusedWithPlaceAndReason) {
  const auto with_count = [](std::uint32_t count) {
    std::string bytes = binary(kTwo);
    std::memcpy(bytes.data() + 80, &count, 4);
    return bytes;
  };
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string text = ascii(kTwo);
  const std::string good = binary(kTwo);
  std::vector<FloatFacet> nan(9, kTwo[0]), far(9, kTwo[0]);
  nan[4][7] = NAN, nan[8][0] = -INFINITY;
  far[3][5] = -10000.5F;
  const struct {
    std::string bytes;
    Code code;
    const char* piece;
  } cases[] = {
      {"", Code::kInput, "f.stl: the file is empty"},
      {"ply\nformat ascii", Code::kInput, "the header has no end_header"},
      {std::string(400, 'v'), Code::kInput, "no STL, OBJ or PLY file"},
      {std::string(400, '\0'), Code::kInput, "says 0 facets (84 bytes), but the file is 400 bytes: 6 whole"},
      {std::string(84, '\0'), Code::kInput, "the binary header says 0 facets"},
      {good.substr(0, 150), Code::kInput,
       "says 2 facets (184 bytes), but the file is 150 bytes: 1 whole facets and 16 bytes; the file is cut "
       "short"},
      {binary(kTwo, "solid part").substr(0, 150), Code::kInput,
       "the binary header says 2 facets (184 bytes)"},
      {replaced(ascii(kTwo, " ", "\r\n"), "1.5", "x"), Code::kInput, "f.stl:13: facet 1: expected a number"},
      {replaced(ascii(kTwo, " ", "\r"), "1.5", "x"), Code::kInput, "f.stl:13: facet 1: expected a number"},
      {with_count(1000), Code::kInput, "says 1000 facets (50084 bytes), but the file is 184 bytes: 2 whole"},
      {with_count(1), Code::kInput, "its count is too low"},
      {with_count(0xFFFFFFFF), Code::kInput, "would mean 4294967295 facets"},
      {binary(nan), Code::kMesh, "2 facets have NaN or infinite coordinates, the first is facet 4"},
      {ascii(nan), Code::kMesh, "2 facets have NaN or infinite coordinates, the first is facet 4"},
      {binary(far), Code::kMesh,
       "1 facets lie beyond the limit of 10000 mm, the first is facet 3 at (1, 0, -10000.5)"},
      {"solid a\nendsolid a\n", Code::kInput, "the file has no facets"},
      {text.substr(0, text.find("vertex 1") + 10), Code::kInput,
       "f.stl:5: facet 0: the file ends where a number is due: it is cut short"},
      {text.substr(0, text.rfind("endsolid")), Code::kInput, "\"endsolid\" is due: it is cut short"},
      {replaced(text, "1.5", "1,5"), Code::kInput, "f.stl:13: facet 1: \"1,5\" has a decimal comma"},
      {replaced(text, "1.5", "1.5.2"), Code::kInput, "f.stl:13: facet 1: expected a number, found \"1.5.2\""},
      {replaced(text, "1.5", ""), Code::kInput, "expected a number, found \"endloop\""},
      {replaced(text, "1.5", "1.5 2"), Code::kInput, "expected \"endloop\", found \"2\""},
      {replaced(text, "endloop", "vertex 1 1 0\nendloop"), Code::kInput,
       "f.stl:7: facet 0: expected three corners"},
      {replaced(text, "vertex 1 0 0\n", ""), Code::kInput, "f.stl:6: facet 0: expected \"vertex\""},
      {replaced(text, "outer loop", "outer lop"), Code::kInput, "expected \"loop\", found \"lop\""},
      {replaced(text, "normal", "\x1b[31m"), Code::kInput, "expected \"normal\", found \"?[31m\""},
      {text + "facet normal 0 0 1\n", Code::kInput, "expected \"solid\", found \"facet\""},
  };
  for (const auto& c : cases) expect_error(parse_stl(c.bytes, "f.stl", 1.0), c.code, c.piece);
  for (double unit : {0.0, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)})
    expect_error(parse_stl(good, "f.stl", unit), Code::kInput, "is not a length");
  expect_error(parse_stl(good, "f.stl", 6667.0), Code::kMesh, "with a unit of 6667 mm");
}

TEST(Stl, NumbersInText) {
  const struct {
    const char* text;
    double value;  ///< NaN: malformed; infinity: read, but refused as not finite
  } cases[] = {{"+1.5", 1.5},        {"-.5", -0.5},     {"5.", 5},          {"1E3", 1000}, {"1e+03", 1000},
               {"1e-45", 0x1p-149},  {"-1e-50", 0},     {"1e-400", 0},      {"0.1", 0.1F}, {"1e39", INFINITY},
               {"-1e400", INFINITY}, {"nan", INFINITY}, {"-inf", INFINITY}, {"0x10", NAN}, {"1d5", NAN},
               {"--1", NAN},         {"+-1", NAN},      {"++1", NAN},       {"1e", NAN},   {"1_000", NAN},
               {"+", NAN},           {"-1.#IND", NAN},  {"1;", NAN},        {"e5", NAN}};
  for (const auto& c : cases) {
    std::string text = ascii(kTwo);
    text.replace(text.find("1.5"), 3, c.text);
    const Result<Stl> stl = parse_stl(text, "f", 1.0);
    if (std::isfinite(c.value)) {
      ASSERT_TRUE(stl) << c.text << ": " << stl.error().message;
      EXPECT_EQ(stl->facets[1][2].z, c.value) << c.text;
    } else {
      expect_error(stl, std::isnan(c.value) ? Code::kInput : Code::kMesh,
                   std::isnan(c.value) ? "expected a number" : "NaN or infinite");
    }
  }
}

TEST(Stl, MutationsNeverCrash) {
  std::mt19937 random(4);
  const std::vector<FloatFacet> facets = random_facets(random, 4);
  const std::string seeds[] = {binary(facets), binary(facets, "solid"), ascii(facets),
                               ascii(facets, " ", " ")};
  const auto below = [&random](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  int accepted = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::string bytes = seeds[round % 4];
    for (std::size_t edits = 1 + below(3); edits > 0 && !bytes.empty(); --edits) {
      const std::size_t at = below(bytes.size()), length = std::min(below(60), bytes.size() - at);
      switch (below(5)) {
        case 0:
          bytes[at] = static_cast<char>(below(256));
          break;
        case 1:
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
          break;
        case 2:
          bytes.erase(at, length);
          break;
        case 3:
          bytes.insert(at, bytes.substr(below(bytes.size()), length));
          break;
        case 4:
          bytes.replace(at, length, "vertex 1e999 -nan ,5 endloop\n", below(30));
          break;
      }
    }
    // A buffer of exactly this size, so that the address sanitizer sees every read beyond it.
    const Result<Stl> stl = parse_stl(std::vector<char>(bytes.begin(), bytes.end()), "f", 1.0);
    if (!stl) {
      ASSERT_FALSE(stl.error().message.empty()) << "round " << round;
      continue;
    }
    ++accepted;
    ASSERT_FALSE(stl->facets.empty()) << "round " << round;
    for (const auto& f : stl->facets)
      for (const Point<Part>& p : f)
        ASSERT_TRUE(std::abs(p.x) <= 1e4 && std::abs(p.y) <= 1e4 && std::abs(p.z) <= 1e4)
            << "round " << round;
  }
  EXPECT_GT(accepted, 1000);  // the mutations reach past the first check
  EXPECT_LT(accepted, 15'000);
}

}  // namespace
}  // namespace tiltfeed
