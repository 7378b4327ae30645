#include "config/yaml_edit.h"

#include <algorithm>
#include <charconv>

#include "config/text_layout.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

constexpr const char* kFile = "job";

/// "holder[2]" as a key and a number from 1; 0: none.
struct Step {
  std::string key;
  std::size_t item = 0;
};

std::vector<Step> steps_of(const std::string& path) {
  std::vector<Step> steps;
  for (std::size_t from = 0; from <= path.size();) {
    const std::size_t dot = std::min(path.find('.', from), path.size());
    Step step{path.substr(from, dot - from)};
    if (const std::size_t open = step.key.find('['); open != std::string::npos) {
      std::from_chars(step.key.data() + open + 1, step.key.data() + step.key.size(), step.item);
      step.key.resize(open);
    }
    steps.push_back(step);
    from = dot + 1;
  }
  return steps;
}

tl::unexpected<Error> refuse(const std::string& path, const std::string& why) {
  return fail(Code::kInput, path + ": " + why);
}

/// The maps and lists around a key, and what the file would say after the change.
class Editor {
 public:
  Editor(const std::string& text, const YamlNode& tree, const KeyOrder& order)
      : text_(text), lay_(text), tree_(tree), order_(order) {}

  Result<std::string> apply(const YamlEdit& edit) {
    const std::vector<Step> steps = steps_of(edit.path);
    const YamlNode* map = &tree_;
    std::string section;
    bool in_flow = lay_.flows(tree_);
    for (std::size_t i = 0;; ++i) {
      if (map->kind != YamlKind::kMap) return refuse(edit.path, "there is no map to hold this key");
      const auto index = key_index(*map, steps[i].key);
      const bool last = i + 1 == steps.size() && steps[i].item == 0;
      if (!index) {
        if (!edit.value) return text_;
        std::string value = *edit.value;
        for (std::size_t k = steps.size() - 1; k > i; --k) value = "{" + steps[k].key + ": " + value + "}";
        return add(*map, section, steps[i].key, value, in_flow);
      }
      const YamlNode& node = map->items[*index];
      if (last && !edit.value) {
        if (map->keys.size() > 1 || section.empty()) return take_out(*map, *index, in_flow);
        return apply({section, std::nullopt});  // a section without keys is none
      }
      if (last) return set(map->keys[*index], node, *edit.value, in_flow);
      section += (section.empty() ? "" : ".") + steps[i].key;
      const YamlNode* next = &node;
      if (steps[i].item > 0) {
        if (node.kind != YamlKind::kList || steps[i].item > node.items.size())
          return refuse(edit.path, "the list has no such item");
        section += "[" + std::to_string(steps[i].item) + "]";
        in_flow = in_flow || lay_.flows(node);
        next = &node.items[steps[i].item - 1];
        if (i + 1 == steps.size()) return item(*next, edit, in_flow);
      }
      if (next->kind == YamlKind::kNothing && edit.value) {
        std::string value = *edit.value;
        for (std::size_t k = steps.size() - 1; k > i; --k) value = "{" + steps[k].key + ": " + value + "}";
        return set(map->keys[*index], node, value, in_flow);
      }
      in_flow = in_flow || (next->kind != YamlKind::kScalar && lay_.flows(*next));
      map = next;
    }
  }

 private:
  Result<std::string> item(const YamlNode& node, const YamlEdit& edit, bool in_flow) const {
    if (!edit.value) return refuse(edit.path, "an item of a list is not taken out alone");
    return replaced(lay_.at(node.place), lay_.end_of(node, in_flow), *edit.value);
  }
  std::string replaced(std::size_t from, std::size_t to, const std::string& by) const {
    return text_.substr(0, from) + by + text_.substr(to);
  }
  std::size_t after_colon(const YamlKey& key) const {
    std::size_t at = lay_.at(key.place);
    if (text_[at] == '"' || text_[at] == '\'') at = text_.find(text_[at], at + 1);
    return text_.find(':', at) + 1;
  }

  std::string set(const YamlKey& key, const YamlNode& node, const std::string& value, bool in_flow) const {
    if (node.kind == YamlKind::kNothing) return replaced(after_colon(key), after_colon(key), " " + value);
    const std::size_t start = lay_.at(node.place), end = lay_.end_of(node, in_flow);
    if (!lay_.is_block(node)) return replaced(start, end, value);
    const std::string without = replaced(lay_.line_start(start), lay_.next_line(end), "");
    const std::size_t at = after_colon(key);
    return without.substr(0, at) + " " + value + without.substr(at);
  }

  /// Behind that key of the map which belongs before the new one; nothing: before all of them.
  std::optional<std::size_t> before(const YamlNode& map, const std::string& section,
                                    const std::string& key) const {
    const std::vector<std::string> known = order_ ? order_(section) : std::vector<std::string>{};
    const auto rank = [&](const std::string& word) {
      return std::find(known.begin(), known.end(), word) - known.begin();
    };
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < map.keys.size(); ++i)
      if (rank(map.keys[i].text) <= rank(key) &&
          (!best || rank(map.keys[i].text) >= rank(map.keys[*best].text)))
        best = i;
    return best;
  }

  std::string add(const YamlNode& map, const std::string& section, const std::string& key,
                  const std::string& value, bool in_flow) const {
    const std::string words = key + ": " + value;
    if (map.keys.empty()) return replaced(lay_.at(map.place) + 1, lay_.at(map.place) + 1, words);
    const auto previous = before(map, section, key);
    if (in_flow) {
      if (!previous) return replaced(lay_.at(map.keys[0].place), lay_.at(map.keys[0].place), words + ", ");
      const std::size_t end = lay_.end_of(map.items[*previous], true);
      return replaced(end, end, ", " + words);
    }
    const std::size_t first = lay_.at(map.keys[0].place), indent = first - lay_.line_start(first);
    if (const auto hidden = hidden_line(map, indent, key)) return shown_again(*hidden, indent, words);
    const bool item = text_.find_first_not_of(' ', lay_.line_start(first)) != first;  // "- key: value"
    if (!previous && !item)
      return replaced(lay_.line_start(first), lay_.line_start(first),
                      std::string(indent, ' ') + words + "\n");
    const std::size_t at = lay_.behind(map.items[previous.value_or(0)], indent);
    const std::string line = std::string(indent, ' ') + words + "\n";
    return replaced(at, at, at > 0 && text_[at - 1] != '\n' ? "\n" + line : line);
  }

  /// The start of a line "  # key: ..." of this map.
  std::optional<std::size_t> hidden_line(const YamlNode& map, std::size_t indent,
                                         const std::string& key) const {
    const std::string sought = std::string(indent, ' ') + "# " + key + ":";
    for (std::size_t at = lay_.line_start(lay_.at(map.keys[0].place)); at < text_.size();
         at = lay_.next_line(at)) {
      const auto in = lay_.indent(at);
      if (in && (*in < indent) && (text_[at + *in] != '#' || *in == 0)) return std::nullopt;
      if (text_.compare(at, sought.size(), sought) == 0) return at;
    }
    return std::nullopt;
  }

  /// The line in use again, its own remark behind the value.
  std::string shown_again(std::size_t start, std::size_t indent, const std::string& words) const {
    const std::size_t end = lay_.line_end(start), remark = text_.find(" # ", start + indent + 2);
    std::string line = std::string(indent, ' ') + words;
    if (remark != std::string::npos && remark < end) {
      const std::size_t column = remark + 1 - start;
      line += std::string(line.size() + 1 < column ? column - line.size() : 1, ' ') +
              text_.substr(remark + 1, end - remark - 1);
    }
    return replaced(start, end, line);
  }

  Result<std::string> take_out(const YamlNode& map, std::size_t index, bool in_flow) const {
    const std::size_t key = lay_.at(map.keys[index].place);
    const std::size_t end = lay_.end_of(map.items[index], in_flow);
    if (in_flow) {
      if (index + 1 < map.keys.size()) return replaced(key, lay_.at(map.keys[index + 1].place), "");
      if (index > 0) return replaced(lay_.end_of(map.items[index - 1], true), end, "");
      return replaced(key, end, "");
    }
    const std::size_t indent = key - lay_.line_start(key);
    if (text_.find_first_not_of(' ', lay_.line_start(key)) != key)
      return refuse(map.keys[index].text, "the first key of a list's item is not taken out");
    std::string out = text_.substr(0, lay_.line_start(key));
    for (std::size_t at = lay_.line_start(key); at < lay_.next_line(end); at = lay_.next_line(at)) {
      const std::string line = text_.substr(at, lay_.next_line(at) - at);
      out += lay_.indent(at) ? line.substr(0, indent) + "# " + line.substr(indent) : line;
    }
    return out + text_.substr(lay_.next_line(end));
  }

  const std::string& text_;
  const TextLayout lay_;
  const YamlNode& tree_;
  const KeyOrder& order_;
};

/// The tree with the change; for what the text ought to read as. Nothing where there is no such place.
bool change(YamlNode& node, const std::vector<Step>& steps, std::size_t i, const YamlNode* value) {
  if (node.kind == YamlKind::kNothing) node = {YamlKind::kMap, node.place, "", true, {}, {}};
  if (node.kind != YamlKind::kMap) return false;
  auto index = key_index(node, steps[i].key);
  const bool last = i + 1 == steps.size();
  if (!index) {
    if (value == nullptr) return true;
    node.keys.push_back({steps[i].key, {}});
    node.items.emplace_back();
    index = node.items.size() - 1;
  }
  YamlNode* next = &node.items[*index];
  if (steps[i].item > 0) {
    if (next->kind != YamlKind::kList || steps[i].item > next->items.size()) return false;
    next = &next->items[steps[i].item - 1];
  }
  if (!last) {
    if (!change(*next, steps, i + 1, value)) return false;
    const bool emptied = next->kind == YamlKind::kMap && next->keys.empty();
    if (value != nullptr || steps[i].item > 0 || !emptied) return true;
  } else if (value != nullptr) {
    *next = *value;
    return true;
  }
  node.keys.erase(node.keys.begin() + static_cast<std::ptrdiff_t>(*index));
  node.items.erase(node.items.begin() + static_cast<std::ptrdiff_t>(*index));
  return true;
}

}  // namespace

Result<std::string> edited(const std::string& text, const YamlEdit& edit, const KeyOrder& order) {
  const Result<YamlNode> tree = parse_yaml(text, kFile);
  if (!tree) return tl::unexpected<Error>(tree.error());
  std::optional<YamlNode> value;
  if (edit.value) {
    const bool one_line = edit.value->find_first_of("\r\n") == std::string::npos;
    const Result<YamlNode> read =
        one_line ? parse_yaml("value: " + *edit.value, kFile) : Result<YamlNode>(YamlNode{});
    if (!read || read->keys.size() != 1 || read->items[0].kind == YamlKind::kNothing)
      return refuse(edit.path,
                    quoted(*edit.value) + " is no value; expected a number, a word, or a list in [ ]");
    value = read->items[0];
  }
  YamlNode wanted = *tree;
  if (!change(wanted, steps_of(edit.path), 0, value ? &*value : nullptr))
    return refuse(edit.path, "the text has no place for this key");
  Result<std::string> changed = Editor(text, *tree, order).apply(edit);
  if (!changed) return changed;
  const Result<YamlNode> now = parse_yaml(*changed, kFile);
  if (!now || !same_value(*now, wanted))
    return refuse(edit.path, "this is written in a way that a form cannot change; change it in the text");
  return changed;
}

std::string quoted_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

Result<std::vector<std::string>> value_texts(const std::string& text, const std::vector<std::string>& paths) {
  const Result<YamlNode> tree = parse_yaml(text, kFile);
  if (!tree) return tl::unexpected<Error>(tree.error());
  const TextLayout lay(text);
  std::vector<std::string> values;
  for (const std::string& path : paths) {
    const YamlNode* node = &*tree;
    bool in_flow = false;
    for (const Step& step : steps_of(path)) {
      const auto index = node->kind == YamlKind::kMap ? key_index(*node, step.key) : std::nullopt;
      in_flow = in_flow || (index && lay.flows(*node));
      node = index ? &node->items[*index] : nullptr;
      if (node != nullptr && step.item > 0) {
        in_flow = in_flow || lay.flows(*node);
        node = node->items.size() >= step.item ? &node->items[step.item - 1] : nullptr;
      }
      if (node == nullptr) break;
    }
    const bool is = node != nullptr && node->kind != YamlKind::kNothing;
    values.push_back(is ? text.substr(lay.at(node->place), lay.end_of(*node, in_flow) - lay.at(node->place))
                        : "");
  }
  return values;
}

}  // namespace tiltfeed::config
