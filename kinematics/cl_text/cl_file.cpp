#include "kinematics/cl_text/cl_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <optional>
#include <ostream>
#include <span>
#include <string_view>

#include "kinematics/basics/decimal.h"

namespace tiltfeed {
namespace {

constexpr int kTipDecimals = 6;
constexpr int kAxisDecimals = 9;
// An axis printed with kAxisDecimals is unit to 1e-9; this also takes files with fewer decimals.
constexpr double kUnit = 1e-4;
// Bytes gathered before they go to the stream.
constexpr std::size_t kChunk = 1 << 16;

constexpr std::string_view kFeedsRemark = "PPRINT TILTFEED FEEDS CUT,PLUNGE ";
constexpr std::string_view kPlungeRemark = "PPRINT TILTFEED PLUNGE";
constexpr std::string_view kCutRemark = "PPRINT TILTFEED CUT";

/// Text gathered in chunks.
class Writer {
 public:
  explicit Writer(std::ostream& out) : out_(out) { text_.reserve(2 * kChunk); }
  ~Writer() { out_.write(text_.data(), static_cast<std::streamsize>(text_.size())); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  Writer& operator<<(std::string_view text) {
    text_ += text;
    if (text_.size() >= kChunk) {
      out_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
      text_.clear();
    }
    return *this;
  }
  Writer& fixed(double value, int decimals) {
    std::array<char, kDecimalSpace> digits;
    return *this << std::string_view(digits.data(),
                                     write_decimal(digits.data(), value, decimals) - digits.data());
  }
  /// The shortest text that reads back as the same double.
  Writer& exact(double value) {
    std::array<char, kDecimalSpace> digits;
    const auto end =
        std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed).ptr;
    return *this << std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data()));
  }

 private:
  std::ostream& out_;
  std::string text_;
};

void write_goto(Writer& w, const Pose& pose) {
  w << "GOTO/";
  const std::array<double, 3> tip{pose.tip.x, pose.tip.y, pose.tip.z};
  const std::array<double, 3> axis{pose.axis.x, pose.axis.y, pose.axis.z};
  for (std::size_t i = 0; i < 3; ++i) (w << (i ? "," : "")).fixed(tip[i], kTipDecimals);
  for (const double value : axis) (w << ",").fixed(value, kAxisDecimals);
  w << "\n";
}

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

bool takes(std::string_view& text, std::string_view prefix) {
  if (text.substr(0, prefix.size()) != prefix) return false;
  text.remove_prefix(prefix.size());
  return true;
}

/// Comma-separated numbers, as many as there are up to the span's size; nothing when one is malformed or one
/// too many.
std::optional<std::size_t> read_numbers(std::string_view text, std::span<double> values) {
  std::size_t count = 0;
  for (;;) {
    text = trimmed(text);
    if (count == values.size()) return std::nullopt;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), values[count]);
    if (error != std::errc{} || !std::isfinite(values[count])) return std::nullopt;
    ++count;
    text = trimmed(text.substr(static_cast<std::size_t>(end - text.data())));
    if (text.empty()) return count;
    if (!takes(text, ",")) return std::nullopt;
  }
}

/// Reads record after record; what was wrong is text, the caller adds the place.
class Reader {
 public:
  /// Nothing when the record is right.
  std::optional<std::string> read(std::string_view record);
  bool ended() const { return ended_; }
  ToolPath take() { return std::move(path_); }
  bool has_moves() const { return !path_.moves.empty(); }

 private:
  std::optional<std::string> read_goto(std::string_view text);
  std::optional<std::string> read_feed(std::string_view text);
  std::optional<std::string> read_tool(std::string_view text);
  std::optional<std::string> read_remark(std::string_view record);

  ToolPath path_;
  bool ended_ = false, rapid_ = false, feeds_stated_ = false, cut_known_ = false, plunge_known_ = false;
  MoveKind feed_kind_ = MoveKind::kCut;
  Vec3 axis_{0.0, 0.0, 1.0};
};

std::optional<std::string> Reader::read_goto(std::string_view text) {
  std::array<double, 6> v{};
  const auto count = read_numbers(text, v);
  if (!count || (*count != 3 && *count != 6)) return "GOTO/ wants x,y,z or x,y,z,i,j,k as decimal numbers";
  if (*count == 6) {
    axis_ = {v[3], v[4], v[5]};
    if (std::abs(length(axis_) - 1.0) > kUnit)
      return "the tool axis is " + decimal(length(axis_), 6) + " long; it must be 1";
    axis_ = normalized(axis_);
  }
  const bool rapid = rapid_ || path_.moves.empty();
  rapid_ = false;
  path_.moves.push_back({{{v[0], v[1], v[2]}, axis_}, rapid ? MoveKind::kRapid : feed_kind_, kNoFacet});
  return std::nullopt;
}

std::optional<std::string> Reader::read_feed(std::string_view text) {
  if (const auto comma = text.find(','); comma != std::string_view::npos) {
    if (trimmed(text.substr(comma + 1)) != "MMPM") return "FEDRAT/ must be in MMPM (mm/min)";
    text = text.substr(0, comma);
  }
  std::array<double, 1> value{};
  if (!read_numbers(text, value) || !(value[0] > 0.0))
    return "FEDRAT/ wants a feed above 0 as a decimal number";
  const Feed feed = Feed::from_mm_per_min(value[0]);
  if (!feeds_stated_ && !cut_known_) path_.cut_feed = feed;
  cut_known_ = true;
  if (!feeds_stated_ && !plunge_known_ && feed != path_.cut_feed) {
    path_.plunge_feed = feed;
    plunge_known_ = true;
  }
  if (feed == path_.cut_feed)
    feed_kind_ = MoveKind::kCut;
  else if (feed == path_.plunge_feed)
    feed_kind_ = MoveKind::kPlunge;
  else
    return "a third feed, " + decimal(value[0], 6) + " mm/min; a path has a cutting feed and a plunge feed";
  return std::nullopt;
}

std::optional<std::string> Reader::read_tool(std::string_view text) {
  std::array<double, 2> value{};
  const auto count = read_numbers(text, value);
  if (!count || value[0] < 0.0 || value[1] < 0.0) return "CUTTER/ wants diameter[,corner radius] in mm";
  path_.tool.diameter = value[0];
  path_.tool.corner_radius = value[1];
  return std::nullopt;
}

/// PPRINT lines are remarks to every other reader; ours state the feeds and, where both feeds are the same,
/// the kind of the moves that follow.
std::optional<std::string> Reader::read_remark(std::string_view record) {
  if (record == kPlungeRemark) feed_kind_ = MoveKind::kPlunge;
  if (record == kCutRemark) feed_kind_ = MoveKind::kCut;
  if (!takes(record, kFeedsRemark)) return std::nullopt;
  std::array<double, 2> feeds{};
  const auto count = read_numbers(record, feeds);
  if (count != 2u || feeds[0] < 0.0 || feeds[1] < 0.0) return "the feeds remark wants two feeds in mm/min";
  path_.cut_feed = Feed::from_mm_per_min(feeds[0]);
  path_.plunge_feed = Feed::from_mm_per_min(feeds[1]);
  feeds_stated_ = true;
  return std::nullopt;
}

std::optional<std::string> Reader::read(std::string_view record) {
  if (ended_) return "text after FINI";
  const std::string_view whole = record;
  if (takes(record, "GOTO/")) return read_goto(record);
  if (takes(record, "FEDRAT/")) return read_feed(record);
  if (takes(record, "PPRINT")) return read_remark(whole);
  if (takes(record, "CUTTER/")) return read_tool(record);
  if (takes(record, "PARTNO")) {
    path_.name = std::string(trimmed(record));
    return std::nullopt;
  }
  if (takes(record, "LOADTL/")) {
    const auto at = record.find("LENGTH,");
    std::array<double, 1> value{};
    if (at == std::string_view::npos || !read_numbers(record.substr(at + 7), value) || value[0] < 0.0)
      return "LOADTL/ wants LENGTH,length in mm";
    path_.tool.length = value[0];
    return std::nullopt;
  }
  if (record == "RAPID") {
    rapid_ = true;
    return std::nullopt;
  }
  if (record == "FINI") {
    ended_ = true;
    return std::nullopt;
  }
  if (record == "UNITS/MM" || record == "MULTAX" || record == "MULTAX/ON") return std::nullopt;
  return "\"" + std::string(whole.substr(0, 40)) +
         "\" is none of PARTNO UNITS/MM MULTAX CUTTER/ LOADTL/ FEDRAT/ RAPID GOTO/ PPRINT FINI";
}

}  // namespace

void write_cl(const ToolPath& path, std::ostream& out) {
  Writer w(out);
  w << "PARTNO " << path.name << "\nUNITS/MM\nMULTAX\nCUTTER/";
  w.exact(path.tool.diameter) << ",";
  w.exact(path.tool.corner_radius) << "\nLOADTL/1,LENGTH,";
  w.exact(path.tool.length) << "\n" << kFeedsRemark;
  w.exact(path.cut_feed.mm_per_min()) << ",";
  w.exact(path.plunge_feed.mm_per_min()) << "\n";
  const bool same_feeds = path.cut_feed == path.plunge_feed;
  std::optional<MoveKind> kind;  // of the feed in force
  for (const Move& move : path.moves) {
    if (move.kind == MoveKind::kRapid) {
      w << "RAPID\n";
    } else if (kind != move.kind) {
      const bool plunge = move.kind == MoveKind::kPlunge;
      if (!kind || !same_feeds) {
        w << "FEDRAT/";
        w.exact((plunge ? path.plunge_feed : path.cut_feed).mm_per_min()) << ",MMPM\n";
      }
      if (same_feeds) w << (plunge ? kPlungeRemark : kCutRemark) << "\n";
      kind = move.kind;
    }
    write_goto(w, move.pose);
  }
  w << "FINI\n";
}

Result<ToolPath> read_cl(std::istream& in, const std::string& name) {
  Reader reader;
  std::string line;
  std::uint64_t number = 0;
  const auto wrong = [&](const std::string& what) {
    return fail(Code::kInput, name + ":" + std::to_string(number) + ": " + what);
  };
  while (std::getline(in, line)) {
    ++number;
    std::string_view record = line;
    if (const auto comment = record.find("$$"); comment != std::string_view::npos)
      record = record.substr(0, comment);
    record = trimmed(record);
    if (record.empty()) continue;
    if (auto mistake = reader.read(record)) return wrong(*mistake);
  }
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read");
  if (!reader.ended()) return wrong("the file ends without FINI: it is cut short");
  if (!reader.has_moves()) return wrong("no GOTO/ before FINI");
  return reader.take();
}

}  // namespace tiltfeed
