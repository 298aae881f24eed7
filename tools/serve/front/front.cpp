// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/front.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "tools/serve/front/answers.h"
#include "tools/serve/front/boot_clock.h"
#include "tools/serve/front/client.h"
#include "tools/serve/front/last_offsets.h"
#include "tools/serve/front/model_process.h"
#include "tools/serve/front/page_link.h"
#include "tools/serve/front/row_clock.h"
#include "tools/serve/front/state_lock.h"
#include "tools/serve/front/takeover.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

constexpr double patience_s = 0.5;       ///< a row without an answer for so long gets the held offsets ...
constexpr double patience_gone_s = 0.1;  ///< ... or for so long while the model is being started ...
constexpr double recorded_s = 10.0;      ///< ... or for so long where no machine waits for it
constexpr double hang_s = 2.0;           ///< a model process that takes longer is ended
constexpr std::size_t enough_ahead = std::size_t{1} << 18U;  ///< bytes of rows that tell a record
constexpr double in_use_s = 5.0;                             ///< a process of the front before may still save its state
constexpr double same_warning_s = 60.0;                      ///< over so long at most ...
constexpr int most_warnings = 10;                            ///< ... so many lines of a kind are written

RowClock::Source source_of(int descriptor) {
  struct stat found {};
  const bool is_file = ::fstat(descriptor, &found) == 0 && S_ISREG(found.st_mode);
  return is_file ? RowClock::Source::file : RowClock::Source::pipe;
}

class Front {
public:
  explicit Front(const FrontOptions& options)
      : options_(options),
        lock_(options.state),
        state_age_s_(age_s(options.state)),
        model_(std::make_unique<ModelProcess>(model_command(options, options.state))),
        takeover_(options),
        answers_(options.json_lines),
        last_offsets_(options.state.string() + ".offsets") {
    if (!options.socket.empty()) listener_ = std::make_unique<Listener>(options.socket);
    if (!listener_) client_ = std::make_unique<Client>(STDIN_FILENO, STDOUT_FILENO, false);
    clock_.begin(listener_ ? RowClock::Source::socket : source_of(STDIN_FILENO), boot_s());
    if (!options.page_command.empty()) page_ = std::make_unique<PageLink>(options.page_command);
    begun_at_ = boot_s();
  }

  void run() {
    while (listener_ || !client_->ended() || model_->oldest() != nullptr) {
      wait();
      check_end();
      now_ = boot_s();
      accept();
      take_rows();
      if (is_other_state_) takeover_.move_state();
      model_->set_longest_answer(is_awaited() ? hang_s : recorded_s);
      model_->tend(now_);
      if (model_->restarts() > 0) is_other_state_ = false;
      give_answers();
      hear_model();
      tend_takeover();
      if (page_) page_->tend(now_);
      if (listener_ && client_ && client_->ended() && model_->oldest() == nullptr) client_.reset();
    }
    finish();
  }

private:
  void finish() {
    last_offsets_.finish();
    model_->end();
    if (is_other_state_) takeover_.move_state();
  }

  void check_end() {
    try {
      core::check_interrupt();
    } catch (const core::Error&) {
      last_offsets_.finish();
      throw;
    }
  }

  void wait() const {
    constexpr int most_ms = 20;
    std::array<pollfd, 4> all{};
    nfds_t count = 0;
    if (client_ && !client_->input_ended() && wants_rows()) all[count++] = {client_->descriptor(), POLLIN, 0};
    if (listener_) all[count++] = {listener_->descriptor(), POLLIN, 0};
    if (model_->descriptor() >= 0) all[count++] = {model_->descriptor(), POLLIN, 0};
    if (takeover_.descriptor() >= 0) all[count++] = {takeover_.descriptor(), POLLIN, 0};
    ::poll(all.data(), count, most_ms);
  }

  static bool has_input(int descriptor) {
    pollfd one{descriptor, POLLIN, 0};
    return ::poll(&one, 1, 0) > 0;
  }

  /// Rows wait with their client while nobody could answer them.
  bool wants_rows() const { return has_announced_ && !new_is_ready_ && model_->has_room(); }

  void warn(const std::string& kind, const std::string& text) {
    Warned& before = warned_[kind];
    if (now_ - before.since >= same_warning_s) before = {now_, 0};
    if (++before.count > most_warnings) return;
    core::warn("serve: " + text);
  }

  void accept() {
    if (!listener_ || !has_input(listener_->descriptor())) return;
    if (client_ && is_leaving(*client_)) return;  // first its last rows are answered
    const int descriptor = ::accept4(listener_->descriptor(), nullptr, nullptr, SOCK_CLOEXEC);
    if (descriptor < 0) return;
    if (client_) {
      warn("busy", "a second client is refused");
      tell_and_close(descriptor, "another client sends rows\n");
      return;
    }
    client_ = std::make_unique<Client>(descriptor, descriptor, true);
    clock_.forget_header();
    gave_header_ = false;
  }

  static bool is_leaving(const Client& client) {
    pollfd one{client.descriptor(), POLLRDHUP, 0};
    return client.input_ended() || ::poll(&one, 1, 0) > 0;
  }

  static void tell_and_close(int descriptor, const std::string& text) {
    [[maybe_unused]] const ssize_t sent = ::send(descriptor, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    ::close(descriptor);
  }

  void take_rows() {
    if (!client_ || !has_announced_) return;
    model_->drop_answered();
    bool is_new = false;
    while (wants_rows() && !client_->input_ended() && has_input(client_->descriptor())) {
      client_->read();
      is_new = true;
      if (!clock_.is_open() || client_->waiting().size() > enough_ahead) break;
    }
    while (wants_rows()) {
      std::string line = client_->line();
      if (line.empty()) return;
      if (clock_.take_header(line)) {
        take_header();
      } else if (!core::trimmed(line).empty()) {  // the model gives no answer to a blank line
        if (std::exchange(is_new, false) && clock_.is_open())
          clock_.look_ahead(line + std::string(client_->waiting()), client_->input_ended(), now_);
        take_row(std::move(line));
      }
    }
  }

  void take_header() {
    if (!clock_.has_header()) return;
    if (!header_.empty() && clock_.header() != header_) {
      has_other_columns_ = true;
      warn("columns", "the rows have other columns than before; the model is started again with them");
    }
    header_ = clock_.header();
    takeover_.set_header(header_);
    model_->set_header(header_);
  }

  void take_row(std::string line) {
    ServedRow row;
    const RowClock::Reading reading = clock_.read(line, now_);
    row.time = reading.time;
    row.stated_s = reading.stated_s;
    row.guard_s = reading.guard_s;
    row.text = std::move(line);
    row.since = now_;
    row.notes = std::exchange(notes_, "");
    if (reading.jump != RowClock::Jump::none) {
      const bool is_back = reading.jump == RowClock::Jump::back;
      row.notes += fmt::format("{}clock={}", row.notes.empty() ? "" : " ", is_back ? "back" : "ahead");
      warn(is_back ? "back" : "ahead", fmt::format("the clock of the rows has gone {} to {} s; time goes on at {} s",
                                                   is_back ? "back" : "ahead", reading.stated_s, reading.time));
    }
    if (std::isfinite(row.time) && !std::exchange(had_row_, true)) {
      if (auto um = last_offsets_.before(axes_, row.time, clock_.is_record())) answers_.go_on_from(std::move(*um));
    }
    takeover_.keep(row, is_cold_start_);
    if (is_blind_ && takeover_.has_all_rows()) is_blind_ = false;
    if (is_blind_) row.notes += row.notes.empty() ? "model=cold" : " model=cold";
    model_->add(std::move(row));
  }

  void note(const std::string& word) { notes_ += (notes_.empty() ? "" : " ") + word; }

  void hear_model() {
    if (const auto refusal = model_->take_refusal()) hear_refusal(*refusal);
    const auto said = model_->take_announcement();
    if (!said || !said->contains("axes")) return;
    if (!answers_.begin(*said)) {
      warn("axes", "the model has other axes than before; its offsets are not used");
      return;
    }
    axes_ = (*said)["axes"].get<std::vector<std::string>>();
    has_other_columns_ = false;
    const bool has_state = (*said)["state_s"].is_number();
    if (!has_announced_ && has_state) clock_.go_on_from((*said)["state_s"], state_age_s_);
    if (!has_announced_) is_cold_start_ = !has_state;
    has_announced_ = true;
  }

  void hear_refusal(const ModelProcess::Refusal& refusal) {
    if (refusal.fault == "in_use") {
      if (!has_announced_ && now_ - begun_at_ > in_use_s) throw core::InputError(refusal.what);
      if (has_announced_) warn("in_use", refusal.what);
      model_->wait_before_start(now_ + 0.2);
    } else if (refusal.fault == "damaged" || refusal.fault == "other_version") {
      put_state_aside(".refused", refusal.what);
    } else if (refusal.fault == "other_model") {
      if (!has_announced_) throw core::InputError(refusal.what);
      // The file was replaced, and a model process started, before the file could be taken over.
      put_state_aside(".before", refusal.what);
      is_blind_ = !takeover_.has_all_rows();
      const auto& rows = takeover_.rows();
      for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
        ServedRow again = *row;
        again.again = true;
        model_->add(std::move(again), true);
      }
    } else if (!refusal.of_rows || refusal.after_answer) {
      if (!has_announced_) throw core::InputError(refusal.what);
      warn("model", refusal.what);
      model_->wait_before_start(now_ + 1.0);
    } else {
      refuse_client(refusal.what);
    }
  }

  void refuse_client(const std::string& what) {
    if (!listener_) throw core::InputError(what);
    core::warn("serve: the client's rows are refused: " + what);
    if (client_) {
      client_->write(what + "\n");
      client_->end();
    }
    client_.reset();
    header_.clear();
    model_->set_header("");
  }

  /// A state that the model cannot go on from would keep it from ever starting.
  void put_state_aside(const char* ending, const std::string& what) {
    const fs::path aside = options_.state.string() + ending;
    std::error_code none;
    fs::rename(options_.state, aside, none);
    if (none) fs::remove(options_.state, none);
    core::warn(fmt::format("serve: {}; kept as {}, cold start", what, aside.string()));
    note("state=refused");
  }

  void tend_takeover() {
    if (!has_announced_) return;
    new_is_ready_ = takeover_.tend(header_, axes_, now_);
    if (takeover_.takes_word_of_waiting()) note("model=waits");
    if (new_is_ready_ && model_->oldest() == nullptr) take_over();
  }

  void take_over() {
    model_->end();
    if (is_other_state_) takeover_.move_state();
    restarts_ += model_->restarts();
    model_ = takeover_.take();
    answers_.begin(takeover_.announcement());
    is_other_state_ = true;
    new_is_ready_ = false;
    if (page_) page_->restart();
    note("model=new");
  }

  /// A machine waits for the answers: rows keep pace with the computer, or a client of the socket has had one already.
  /// The first one may have to wait for a model of other columns.
  bool is_awaited() const { return clock_.is_in_real_time() || (listener_ && gave_header_); }

  void give_answers() {
    while (auto next = model_->answer(now_)) {
      if (next->row.again || next->row.answered) continue;
      const bool is_answer = next->json.is_object() && next->json.contains("wanted_um");
      if (is_answer && next->json.contains("state")) note_unwritten(next->row);
      give(next->row, is_answer ? answers_.of_model(next->row, std::move(next->json))
                                : answers_.without_model(next->row, "model=gone"));
    }
    while (ServedRow* late = answers_.has_any() ? model_->oldest() : nullptr) {
      const double live_s = model_->is_up() ? patience_s : patience_gone_s;
      if (!late->lost && now_ - late->since < (is_awaited() ? live_s : recorded_s)) return;
      late->answered = true;
      const bool is_late = model_->is_up() && !late->lost;
      give(*late, answers_.without_model(*late, is_late              ? "model=late"
                                                : has_other_columns_ ? "model=columns"
                                                                     : "model=gone"));
    }
  }

  void note_unwritten(ServedRow& row) { row.notes += row.notes.empty() ? "state=unwritten" : " state=unwritten"; }

  void give(const ServedRow& row, const nlohmann::json& answer) {
    if (client_) {
      if (!gave_header_ && !options_.json_lines) client_->write(answers_.header());
      gave_header_ = true;
      client_->write(answers_.text());
    }
    if (!clock_.is_record() && std::isfinite(row.time))
      last_offsets_.keep(answers_.axes(), answers_.applied_um(), row.time, now_);
    if (!page_ || !std::isfinite(row.time)) return;
    nlohmann::json moment = answer;
    moment["model_is_up"] = model_->is_up();
    moment["restarts"] = restarts_ + model_->restarts();
    page_->show(std::move(moment), row.time, now_);
  }

  const FrontOptions& options_;
  StateLock lock_;
  double state_age_s_;
  std::unique_ptr<ModelProcess> model_;
  Takeover takeover_;
  Answers answers_;
  LastOffsets last_offsets_;
  std::unique_ptr<Listener> listener_;
  std::unique_ptr<Client> client_;
  std::unique_ptr<PageLink> page_;
  RowClock clock_;
  std::vector<std::string> axes_;
  std::string header_, notes_;  ///< notes_: words for the status of the next row
  struct Warned {
    double since = -same_warning_s;  ///< first of the lines that count
    int count = 0;
  };
  std::map<std::string, Warned> warned_;
  double begun_at_ = 0, now_ = 0;
  unsigned restarts_ = 0;        ///< of models before
  bool new_is_ready_ = false;    ///< it replaces the model once that has answered its rows
  bool is_other_state_ = false;  ///< the model was taken over and has not been started again
  bool has_announced_ = false, gave_header_ = false, had_row_ = false;
  bool has_other_columns_ = false;  ///< the model is being started again for them
  bool is_cold_start_ = false;      ///< there was no state to go on from
  bool is_blind_ = false;           ///< the model began cold, without the rows that it had to know
};

}  // namespace

void run_front(const FrontOptions& options) { Front(options).run(); }

}  // namespace thermotwin::tools
