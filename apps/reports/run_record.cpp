#include "apps/reports/run_record.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "scan/base/parallel.h"
#include "scan/units/content_hash.h"
#include "scan/units/input_hash.h"

namespace relief {

namespace {

// A word that an option takes, and what CLI11 replaces it with.
struct Word {
  std::string word, value;
};

// The words of an option, from what its checks say of them: `{keep,auto}`, or `value in
// {auto->1,off->0} OR {1,0}` where they stand for values. Other options have none.
std::vector<Word> words_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  std::vector<Word> words;
  std::istringstream list(type.substr(begin + 1, end - begin - 1));
  for (std::string word; std::getline(list, word, ',');) {
    const std::size_t arrow = word.find("->");
    if (arrow == std::string::npos)
      words.push_back({word, word});
    else
      words.push_back({word.substr(0, arrow), word.substr(arrow + 2)});
  }
  return words;
}

// The results of an option that was given hold values in place of words.
std::string given_text(const CLI::Option& option, const std::vector<Word>& words) {
  std::string text;
  for (const std::string& result : option.results()) {
    const auto found = std::find_if(words.begin(), words.end(),
                                    [&](const Word& word) { return word.value == result; });
    text += (text.empty() ? "" : " ") + (found == words.end() ? result : found->word);
  }
  return text;
}

// Whether an option that was given excludes this one, as its former name does.
bool is_replaced(const CLI::Option& option) {
  const auto others = option.get_excludes();
  return std::any_of(others.begin(), others.end(),
                     [](const CLI::Option* other) { return other->count() > 0; });
}

std::optional<std::string> text_of(const CLI::Option& option) {
  const std::vector<Word> words = words_of(option);
  if (option.count() > 0) return given_text(option, words);
  const std::string word = option.get_default_str();
  const bool known = std::any_of(words.begin(), words.end(),
                                 [&](const Word& other) { return other.word == word; });
  return known && !is_replaced(option) ? std::optional(word) : std::nullopt;
}

// Option groups are nameless commands within the command.
void add_options(const CLI::App& command, Json& options) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_lnames().empty()) continue;
    if (const auto text = text_of(*option)) options["--" + option->get_lnames().front()] = *text;
  }
  for (const CLI::App* group : command.get_subcommands(nullptr))
    if (group->get_name().empty()) add_options(*group, options);
}

}  // namespace

Json run_record(const std::filesystem::path& input, const CLI::App& command) {
  Json options = Json::object();
  add_options(command, options);
  return {
      {"input", input.string()}, {"program", program_identity()}, {"options", std::move(options)}};
}

Json input_record(const std::vector<RangeView>& views) {
  const auto samples = parallel_map<std::string>(
      views.size(), [&](std::size_t i) { return hash_of_samples(views[i]); });
  Json list = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    ContentHash pose;
    pose.add(views[i].world_from_view, views[i].pose);
    list.push_back(
        {{"name", views[i].name}, {"samples_sha256", samples[i]}, {"pose_sha256", pose.hex()}});
  }
  return list;
}

}  // namespace relief
