#include "config/yaml_tree.h"

#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>

namespace tiltfeed::config {
namespace {

constexpr std::size_t kMaxQuoted = 60;

TextPlace place_of(const YAML::Mark& mark) {
  if (mark.is_null()) return {};
  return {mark.line + 1, mark.column + 1};
}

/// Builds the tree from the parser's events. yaml-cpp's own node tree is not used because it keeps the first
/// of two equal keys in silence and expands aliases; the events show both. After the first problem the
/// remaining events are ignored.
class TreeBuilder final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) refuse(mark, "a second document starts here; expected one document per file");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { add(mark, "?", YamlKind::kNothing, ""); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    refuse(mark, "aliases (*name) are not supported; write the value out");
  }
  void OnAnchor(const YAML::Mark& mark, const std::string& name) override {
    refuse(mark,
           "anchors (" + quoted("&" + name) + ") are not supported; write the value out where it is needed");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                const std::string& text) override {
    add(mark, tag, YamlKind::kScalar, text);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, YamlKind::kList);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, YamlKind::kMap);
  }
  void OnMapEnd() override { close(); }

  struct Problem {
    TextPlace place;
    std::string message;
  };
  const std::optional<Problem>& problem() const { return problem_; }
  YamlNode take_root() { return std::move(root_); }

 private:
  void refuse(const YAML::Mark& mark, std::string message) { refuse(place_of(mark), std::move(message)); }
  void refuse(TextPlace place, std::string message) {
    if (!problem_) problem_ = Problem{place, std::move(message)};
  }

  /// yaml-cpp's tags: "?" a plain value, "!" a quoted one, anything else was written in the file.
  bool tag_is_own(const YAML::Mark& mark, const std::string& tag) {
    if (tag.empty() || tag == "?" || tag == "!") return true;
    refuse(mark, "tags (" + quoted(tag) + ") are not supported; write the plain value");
    return false;
  }

  bool awaits_key() const {
    return !open_.empty() && open_.back().kind == YamlKind::kMap &&
           open_.back().keys.size() == open_.back().items.size();
  }

  void add_key(TextPlace place, const std::string& text, bool plain) {
    YamlNode& map = open_.back();
    if (plain && text == "<<") return refuse(place, "merge keys (<<) are not supported; write the keys out");
    const auto twin =
        std::find_if(map.keys.begin(), map.keys.end(), [&](const YamlKey& key) { return key.text == text; });
    if (twin != map.keys.end())
      return refuse(place, "duplicate key " + quoted(text) + ", first given on line " +
                               std::to_string(twin->place.line) + "; keep one of the two");
    map.keys.push_back({text, place});
  }

  void add(const YAML::Mark& mark, const std::string& tag, YamlKind kind, const std::string& text) {
    if (problem_ || !tag_is_own(mark, tag)) return;
    if (awaits_key()) {
      if (kind != YamlKind::kScalar) return refuse(mark, "a key is missing before the ':'");
      return add_key(place_of(mark), text, tag == "?");
    }
    YamlNode node{kind, place_of(mark), text, tag != "!", {}, {}};
    if (kind == YamlKind::kNothing && !open_.empty() && open_.back().kind == YamlKind::kMap)
      node.place = open_.back().keys.back().place;
    put(std::move(node));
  }

  void open(const YAML::Mark& mark, const std::string& tag, YamlKind kind) {
    if (problem_ || !tag_is_own(mark, tag)) return;
    if (awaits_key()) return refuse(mark, "a map or list cannot be a key; expected a word");
    open_.push_back({kind, place_of(mark), "", true, {}, {}});
  }

  void close() {
    if (problem_) return;
    assert(!open_.empty());
    YamlNode node = std::move(open_.back());
    open_.pop_back();
    put(std::move(node));
  }

  void put(YamlNode node) {
    if (open_.empty())
      root_ = std::move(node);
    else
      open_.back().items.push_back(std::move(node));
  }

  YamlNode root_;
  std::vector<YamlNode> open_;  ///< maps and lists not yet closed, outermost first
  std::optional<Problem> problem_;
  int documents_ = 0;
};

/// The first byte that has no business in a settings file. yaml-cpp would take lone carriage returns and
/// tabs between words as blanks, and guess UTF-16 from NUL bytes.
std::optional<TreeBuilder::Problem> bad_byte(const std::string& text) {
  TextPlace place;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool line_end = byte == '\r' && i + 1 < text.size() && text[i + 1] == '\n';
    if (byte == '\t') return TreeBuilder::Problem{place, "tab character; expected spaces"};
    // 0xC0, 0xC1 and 0xF5 upwards never occur in UTF-8; UTF-16 files start with two of them.
    if ((byte < 0x20 && byte != '\n' && !line_end) || byte == 0x7F || byte == 0xC0 || byte == 0xC1 ||
        byte >= 0xF5)
      return TreeBuilder::Problem{
          place, "byte " + std::to_string(byte) + " is not text; expected UTF-8 without control characters"};
    place = byte == '\n' ? TextPlace{place.line + 1, 1} : TextPlace{place.line, place.column + 1};
  }
  return std::nullopt;
}

}  // namespace

std::string to_string(const std::string& file, TextPlace place) {
  return file + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
}

std::string quoted(const std::string& text) {
  std::size_t end = std::min(text.size(), kMaxQuoted);
  while (end > 0 && end < text.size() && (text[end] & 0xC0) == 0x80) --end;  // not inside a UTF-8 letter
  std::string shown = "'";
  for (const char letter : text.substr(0, end)) {
    const auto byte = static_cast<unsigned char>(letter);
    shown += byte < 0x20 || byte == 0x7F ? '?' : letter;
  }
  return shown + (end < text.size() ? "...'" : "'");
}

std::string found(const YamlNode& node) {
  switch (node.kind) {
    case YamlKind::kNothing:
      return "found nothing";
    case YamlKind::kList:
      return "found a list of " + std::to_string(node.items.size());
    case YamlKind::kMap:
      return "found a map";
    case YamlKind::kScalar:
      break;
  }
  return "found " + std::string(node.plain ? "" : "the quoted text ") + quoted(node.text);
}

Result<std::string> read_config_text(const std::string& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  std::string text(kMaxConfigBytes + 1, '\0');
  if (in) in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in.is_open() || in.bad() || (in.fail() && !in.eof())) {
    const std::string reason = errno != 0 ? std::strerror(errno) : "read error";
    return fail(Code::kIo, path + ": cannot read: " + reason + "; check the name and its permissions");
  }
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxConfigBytes)
    return fail(Code::kInput, path + ":1:1: the file is over the limit of " +
                                  std::to_string(kMaxConfigBytes) + " bytes; is it a settings file?");
  return text;
}

Result<YamlNode> parse_yaml(const std::string& text, const std::string& file) {
  const auto report = [&](TextPlace place, const std::string& message) {
    return fail(Code::kInput, to_string(file, place) + ": " + message);
  };
  if (text.size() > kMaxConfigBytes)
    return report({}, "the text is over the limit of " + std::to_string(kMaxConfigBytes) + " bytes");
  if (const auto problem = bad_byte(text)) return report(problem->place, problem->message);

  TreeBuilder builder;
  try {
    std::istringstream in(text);
    YAML::Parser parser(in);
    bool any = false;
    while (!builder.problem() && parser.HandleNextDocument(builder)) any = true;
    if (!any) return report({}, "the file is empty; expected keys and values");
  } catch (const YAML::DeepRecursion& error) {
    if (!builder.problem()) return report(place_of(error.mark), "nested too deeply; expected plain settings");
  } catch (const YAML::Exception& error) {
    // What the builder refused stands earlier in the file than what the parser stumbled over.
    if (!builder.problem()) return report(place_of(error.mark), "not valid YAML: " + error.msg);
  }
  if (builder.problem()) return report(builder.problem()->place, builder.problem()->message);
  return builder.take_root();
}

}  // namespace tiltfeed::config
