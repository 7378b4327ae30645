#include "config/list_edit.h"

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <vector>

#include "config/text_layout.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

constexpr const char* kListFile = "job";

/// A list of a file's root, and the pieces of text that its items are.
class ListText {
 public:
  /// Requires: `text` and `tree` outlive it, tree.items[index] is a list with items.
  ListText(const std::string& text, const YamlNode& tree, std::size_t index)
      : text_(text), lay_(text), list_(tree.items[index]), in_flow_(lay_.flows(list_)) {
    if (in_flow_) {
      for (const YamlNode& item : list_.items) {
        begins_.push_back(lay_.at(item.place));
        ends_.push_back(lay_.end_of(item, true));
      }
      return;
    }
    const std::size_t after_key = lay_.next_line(lay_.at(tree.keys[index].place));
    for (const YamlNode& item : list_.items) {
      const std::size_t dash = text_.rfind('-', lay_.at(item.place) - 1);
      const std::size_t line = lay_.line_start(dash);
      indent_ = dash - line;
      lines_.push_back(line);
      begins_.push_back(above(line, after_key));
    }
    ends_.assign(begins_.begin() + 1, begins_.end());
    ends_.push_back(lay_.behind(list_.items.back(), indent_));
  }

  bool in_flow() const { return in_flow_; }
  /// In braces an item's own text; by indents whole lines, with the remarks above them and what is empty
  /// below.
  std::vector<std::string> pieces() const {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < begins_.size(); ++i) all.push_back(part(begins_[i], ends_[i]));
    return all;
  }
  /// The item from its dash on, without what is around it.
  std::string core(std::size_t i) const {
    return in_flow_ ? part(begins_[i], ends_[i]) : part(lines_[i], end(i));
  }
  std::string before_core(std::size_t i) const { return text_.substr(begins_[i], start(i) - begins_[i]); }
  std::string behind_core(std::size_t i) const { return text_.substr(end(i), ends_[i] - end(i)); }
  std::size_t indent() const { return indent_; }

  /// The text with these in place of the items.
  std::string with(const std::vector<std::string>& pieces) const {
    std::string out = text_.substr(0, begins_.front());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (in_flow_ && i > 0) out += i < begins_.size() ? between(i) : ", ";
      out += pieces[i];
    }
    return out + text_.substr(ends_.back());
  }

 private:
  std::size_t start(std::size_t i) const { return in_flow_ ? begins_[i] : lines_[i]; }
  std::size_t end(std::size_t i) const { return in_flow_ ? ends_[i] : lay_.behind(list_.items[i], indent_); }
  /// The last line of a text may lack its end.
  std::string part(std::size_t from, std::size_t to) const {
    std::string text = text_.substr(from, to - from);
    if (!in_flow_ && (text.empty() || text.back() != '\n')) text += '\n';
    return text;
  }
  std::string between(std::size_t i) const { return text_.substr(ends_[i - 1], begins_[i] - ends_[i - 1]); }
  /// The first of the remarks at the items' own indent that stand right above a line.
  std::size_t above(std::size_t line, std::size_t least) const {
    while (line > least) {
      const std::size_t before = lay_.line_start(line - 1);
      const auto in = lay_.indent(before);
      if (before < least || !in || *in != indent_ || text_[before + *in] != '#') break;
      line = before;
    }
    return line;
  }

  const std::string& text_;
  const TextLayout lay_;
  const YamlNode& list_;
  bool in_flow_;
  std::size_t indent_ = 0;          ///< of the dashes
  std::vector<std::size_t> lines_;  ///< where the dashes' lines begin
  std::vector<std::size_t> begins_, ends_;
};

tl::unexpected<Error> refused(const std::string& list, const std::string& why) {
  return fail(Code::kInput, list + ": " + why);
}

/// What becomes of the items' texts, and of their values.
struct ListChange {
  std::function<std::vector<std::string>(const ListText&)> texts;
  std::function<void(std::vector<YamlNode>&)> values;
};

Result<std::string> changed(const std::string& text, const std::string& list,
                            std::initializer_list<std::size_t> numbers, const ListChange& change) {
  const Result<YamlNode> tree = parse_yaml(text, kListFile);
  if (!tree) return tl::unexpected<Error>(tree.error());
  const auto index = tree->kind == YamlKind::kMap ? key_index(*tree, list) : std::nullopt;
  if (!index || tree->items[*index].kind != YamlKind::kList || tree->items[*index].items.empty())
    return refused(list, "there is no such list");
  for (const std::size_t number : numbers)
    if (number < 1 || number > tree->items[*index].items.size())
      return refused(list, "there is no number " + std::to_string(number) + " in it");
  YamlNode wanted = *tree;
  change.values(wanted.items[*index].items);
  if (wanted.items[*index].items.empty()) return refused(list, "this is the only one; it stays");
  const ListText old(text, *tree, *index);
  std::string out = old.with(change.texts(old));
  const Result<YamlNode> now = parse_yaml(out, kListFile);
  if (!now || !same_value(*now, wanted))
    return refused(list, "this list is written in a way that a form cannot change; change it in the text");
  return out;
}

/// Every line becomes a remark, further in than `indent` as it was.
std::string as_remarks(const std::string& lines, std::size_t indent) {
  std::string out;
  for (std::size_t at = 0; at < lines.size();) {
    const std::size_t end = std::min(lines.find('\n', at), lines.size() - 1) + 1;
    const std::string line = lines.substr(at, end - at);
    const std::size_t first = line.find_first_not_of(" \r\n");
    const std::size_t in = std::min(indent, first);
    out += first == std::string::npos ? line : line.substr(0, in) + "# " + line.substr(in);
    at = end;
  }
  return out;
}

template <class T>
void move_within(std::vector<T>& all, std::size_t from, std::size_t to) {
  const auto at = [&](std::size_t i) { return all.begin() + static_cast<std::ptrdiff_t>(i); };
  if (from < to)
    std::rotate(at(from), at(from + 1), at(to + 1));
  else
    std::rotate(at(to), at(from), at(from + 1));
}

}  // namespace

Result<std::string> item_copied(const std::string& text, const std::string& list, std::size_t number) {
  const std::size_t i = number - 1;
  return changed(text, list, {number},
                 {[i](const ListText& old) {
                    std::vector<std::string> all = old.pieces();
                    all[i] = old.before_core(i) + old.core(i);
                    all.insert(all.begin() + static_cast<std::ptrdiff_t>(i + 1),
                               old.core(i) + old.behind_core(i));
                    return all;
                  },
                  [i](std::vector<YamlNode>& items) {
                    const YamlNode copy = items[i];
                    items.insert(items.begin() + static_cast<std::ptrdiff_t>(i) + 1, copy);
                  }});
}

Result<std::string> item_moved(const std::string& text, const std::string& list, std::size_t from,
                               std::size_t to) {
  return changed(text, list, {from, to},
                 {[=](const ListText& old) {
                    std::vector<std::string> all = old.pieces();
                    move_within(all, from - 1, to - 1);
                    return all;
                  },
                  [=](std::vector<YamlNode>& items) { move_within(items, from - 1, to - 1); }});
}

Result<std::string> item_taken_out(const std::string& text, const std::string& list, std::size_t number) {
  const std::size_t i = number - 1;
  return changed(
      text, list, {number},
      {[i](const ListText& old) {
         std::vector<std::string> all = old.pieces();
         if (old.in_flow())
           all.erase(all.begin() + static_cast<std::ptrdiff_t>(i));
         else
           all[i] = old.before_core(i) + as_remarks(old.core(i), old.indent()) + old.behind_core(i);
         return all;
       },
       [i](std::vector<YamlNode>& items) { items.erase(items.begin() + static_cast<std::ptrdiff_t>(i)); }});
}

}  // namespace tiltfeed::config
