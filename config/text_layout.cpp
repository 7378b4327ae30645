#include "config/text_layout.h"

#include <algorithm>

namespace tiltfeed::config {

TextLayout::TextLayout(const std::string& text) : text_(text) {
  starts_.push_back(0);
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\n') starts_.push_back(i + 1);
}

std::size_t TextLayout::line_start(std::size_t at) const {
  return *(std::upper_bound(starts_.begin(), starts_.end(), at) - 1);
}

std::size_t TextLayout::line_end(std::size_t at) const {
  return std::min(text_.find('\n', at), text_.size());
}

std::size_t TextLayout::next_line(std::size_t at) const { return std::min(line_end(at) + 1, text_.size()); }

std::optional<std::size_t> TextLayout::indent(std::size_t start) const {
  const std::size_t first = text_.find_first_not_of(" \r", start);
  if (first == std::string::npos || text_[first] == '\n') return std::nullopt;
  return first - start;
}

bool TextLayout::flows(const YamlNode& node) const {
  return text_[at(node.place)] == '[' || text_[at(node.place)] == '{';
}

bool TextLayout::is_block(const YamlNode& node) const {
  return (node.kind == YamlKind::kMap || node.kind == YamlKind::kList) && !flows(node);
}

std::size_t TextLayout::end_of(const YamlNode& node, bool in_flow) const {
  const std::size_t start = at(node.place);
  if (node.kind == YamlKind::kNothing) return text_.find(':', start) + 1;
  if (is_block(node)) return node.items.empty() ? start : end_of(node.items.back(), false);
  if (flows(node)) return closing(start);
  if (text_[start] == '"' || text_[start] == '\'') return quote_end(start);
  std::size_t end = start;
  while (end < text_.size() && text_[end] != '\n' && text_[end] != '\r' &&
         !(text_[end] == '#' && end > 0 && text_[end - 1] == ' ') &&
         !(in_flow && std::string(",[]{}").find(text_[end]) != std::string::npos))
    ++end;
  while (end > start && text_[end - 1] == ' ') --end;
  return end;
}

std::size_t TextLayout::behind(const YamlNode& node, std::size_t indent) const {
  std::size_t at = next_line(end_of(node, false));
  while (at < text_.size()) {
    const auto in = this->indent(at);
    if (!in || *in <= indent || text_[at + *in] != '#') break;
    at = next_line(at);
  }
  return at;
}

std::size_t TextLayout::quote_end(std::size_t start) const {
  const char quote = text_[start];
  for (std::size_t i = start + 1; i < text_.size(); ++i) {
    if (text_[i] == '\\' && quote == '"') {
      ++i;
    } else if (text_[i] == quote) {
      if (quote == '"' || i + 1 >= text_.size() || text_[i + 1] != '\'') return i + 1;
      ++i;
    }
  }
  return text_.size();
}

std::size_t TextLayout::closing(std::size_t start) const {
  int depth = 0;
  for (std::size_t i = start; i < text_.size(); ++i) {
    const char c = text_[i];
    if (c == '"' || c == '\'') {
      i = quote_end(i) - 1;
    } else if (c == '#' && text_[i - 1] == ' ') {
      i = line_end(i);
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if ((c == ']' || c == '}') && --depth == 0) {
      return i + 1;
    }
  }
  return text_.size();
}

std::optional<std::size_t> key_index(const YamlNode& map, const std::string& key) {
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (map.keys[i].text == key) return i;
  return std::nullopt;
}

bool same_value(const YamlNode& a, const YamlNode& b) {
  if (a.kind != b.kind || a.items.size() != b.items.size()) return false;
  if (a.kind == YamlKind::kScalar) return a.text == b.text && a.plain == b.plain;
  for (std::size_t i = 0; i < a.items.size(); ++i) {
    const auto other = a.kind == YamlKind::kMap ? key_index(b, a.keys[i].text) : std::optional(i);
    if (!other || !same_value(a.items[i], b.items[*other])) return false;
  }
  return true;
}

}  // namespace tiltfeed::config
