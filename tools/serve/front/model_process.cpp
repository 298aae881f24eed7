// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/model_process.h"

#include <array>
#include <csignal>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace thermotwin::tools {
namespace {

constexpr std::size_t most_rows = 16;
constexpr double end_wait_s = 5.0;  ///< for its last state
constexpr double longest_start_s = 120.0;
constexpr int pipe_bytes = 1 << 20;

}  // namespace

ModelProcess::ModelProcess(std::vector<std::string> command) {
  set_command(std::move(command));
  process_link_begin(&link_, "serve", pointers_.data());
}

void ModelProcess::set_command(std::vector<std::string> command) {
  command_ = std::move(command);
  pointers_.clear();
  for (const std::string& word : command_) pointers_.push_back(word.c_str());
  pointers_.push_back(nullptr);
  link_.arguments = pointers_.data();
}

ModelProcess::~ModelProcess() { end(); }

void ModelProcess::end() { process_link_end(&link_, end_wait_s); }

void ModelProcess::set_header(const std::string& header) {
  if (header == header_) return;
  if (fed_header_ && link_.process > 0) end();
  for (auto* rows : {&waiting_, &sent_, &lost_}) rows->clear();  // of other columns
  header_ = header;
  header_answered_ = false;
}

bool ModelProcess::has_room() const { return waiting_.size() < most_rows; }

void ModelProcess::drop_answered() {
  while (waiting_.size() >= most_rows && waiting_.front().answered) waiting_.pop_front();
}

void ModelProcess::add(ServedRow row, bool first) {
  if (first)
    waiting_.push_front(std::move(row));
  else
    waiting_.push_back(std::move(row));
}

/// Rows that the process before had taken are not sent again, since one of them may have ended it. Before the very
/// first answer they are, since nobody else can answer them.
void ModelProcess::begin_process() {
  seen_starts_ = link_.starts;
  part_.clear();
  announced_ = fed_header_ = false;
  announcement_.reset();
  fcntl(link_.to, F_SETPIPE_SZ, pipe_bytes);
  for (; !sent_.empty(); sent_.pop_back()) {
    ServedRow& row = sent_.back();
    if (row.again || row.answered) continue;
    row.lost = ever_answered_;
    (ever_answered_ ? lost_ : waiting_).push_front(std::move(row));
  }
}

void ModelProcess::feed(double now) {
  if (!announced_ || header_.empty()) return;
  if (!fed_header_) {
    fed_header_ = ::write(link_.to, header_.data(), header_.size()) == std::ssize(header_);
    if (!fed_header_) return;
  }
  while (!waiting_.empty()) {
    const std::string& text = waiting_.front().text;
    if (process_link_send(&link_, text.data(), text.size(), now) == 0) return;
    sent_.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
  }
}

void ModelProcess::tend(double now) {
  process_link_tend(&link_, now);
  if (link_.process <= 0) {
    announced_ = false;
    return;
  }
  if (link_.starts != seen_starts_) begin_process();
  if (!announced_ && now - link_.begun_at > longest_start_s) ::kill(link_.process, SIGKILL);
  feed(now);
}

std::optional<ModelProcess::Answer> ModelProcess::answer(double now) {
  std::array<char, 65536> bytes{};
  for (;;) {
    std::size_t end = part_.find('\n');
    while (end == std::string::npos) {
      const std::size_t count = process_link_read(&link_, bytes.data(), bytes.size(), 0);
      if (count == 0) return std::nullopt;
      const std::size_t before = part_.size();
      part_.append(bytes.data(), count);
      end = part_.find('\n', before);
    }
    nlohmann::json json =
        nlohmann::json::parse(part_.begin(), part_.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
    part_.erase(0, end + 1);
    if (json.is_object() && json.contains("refused")) {
      refusal_ = Refusal{json.value("refused", ""), json.value("what", ""), announced_, header_answered_};
      this->end();  // it has said its last
      return std::nullopt;
    }
    if (!announced_) {
      announced_ = true;
      announcement_ = std::move(json);
      continue;
    }
    process_link_answered(&link_, now);
    if (sent_.empty()) continue;
    header_answered_ = ever_answered_ = true;
    Answer answer{std::move(sent_.front()), std::move(json)};
    sent_.pop_front();
    return answer;
  }
}

std::optional<ModelProcess::Refusal> ModelProcess::take_refusal() { return std::exchange(refusal_, std::nullopt); }

std::optional<nlohmann::json> ModelProcess::take_announcement() { return std::exchange(announcement_, std::nullopt); }

ServedRow* ModelProcess::oldest() {
  while (!lost_.empty() && lost_.front().answered) lost_.pop_front();
  for (std::deque<ServedRow>* rows : {&lost_, &sent_, &waiting_}) {
    for (ServedRow& row : *rows)
      if (!row.again && !row.answered) return &row;
  }
  return nullptr;
}

}  // namespace thermotwin::tools
