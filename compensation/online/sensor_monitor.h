// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Detects and names temperature sensors that have failed, so that the observer leaves them out. A reading is compared
// with the observer's expectation. The slow part of the difference is model error and is tracked; a jump from one
// reading to the next is attributed to the sensor:
// - absent: no reading for five minutes, after there was one;
// - stuck: the same reading (to a tenth of its standard deviation) while the expected one has changed by 5 sigma, with
//   and without what the observer has learnt meanwhile; or the same reading for five minutes, more often in a row than
//   its own scatter allows by chance (1e-12). Readings of a simulation, or of a filter, hardly scatter and may repeat
//   as long as the machine stands still. Expected readings follow quick rows (less than 30 s apart) up to 90 s late;
//   what they do until then does not count;
// - offset: the reading, and its difference from the expected one, jump by more than 12 sigma and stay there for 30 s
//   (150 s behind a jump of an input beside quick rows, which the expected reading follows late), or the
//   difference exceeds 1 K from the start and is far larger than that of the other sensors;
// - noise: second differences of the reading, and of its difference from the expected one, beyond 3.5 of their standard
//   deviations in quick succession.
// Readings after a jump are withheld at once, before the fault is named. sigma is the sensor's stated standard
// deviation, at least 0.03 K, plus a tenth of the change of the expected reading, because model errors are largest
// during changes. If an input has jumped since the row before, jumps and noise have to exceed the whole change of the
// expected reading, because the time of the change between the rows is unknown. A sensor returns after its readings
// have agreed for half an hour without a break, to less than half of the jump. Limits: a slow drift is taken for model
// error (drift_watch.h finds it), and an initial offset below the differences among neighbours is not found.

#include <Eigen/Core>

#include <array>
#include <deque>
#include <string>
#include <vector>

namespace thermotwin::compensation {

enum class SensorFault { none, absent, stuck, offset, noise };
const char* fault_text(SensorFault fault);

class SensorMonitor {
public:
  /// @param deviation_K  (sensors) stated standard deviation of a reading
  explicit SensorMonitor(const Eigen::VectorXd& deviation_K);

  /// Judges the readings of one time. @param reading_K  (sensors) NaN where missing
  /// @param expected_K  (sensors) by the observer  @param inputs_leapt  since the last call: a speed, a state
  /// @param unsure_K_s  (sensors) standard deviation of how fast the expected readings change; empty: they are sure
  /// @return whether the fault of any sensor changed
  bool judge(double time, const Eigen::VectorXd& reading_K, const Eigen::VectorXd& expected_K,
             bool inputs_leapt = false, const Eigen::VectorXd& unsure_K_s = {});
  /// States, before the first readings, the sensors whose first reading the others explain, however large it is.
  void explain_first(std::vector<char> explained) { explained_ = std::move(explained); }
  /// Shifts the expected readings after the observer has learnt, so that no sensor is blamed for the change.
  void correct(const Eigen::VectorXd& change_K);

  /// @return whether the last reading may correct the model
  bool trusted(Eigen::Index sensor) const { return sensors_[sensor].trusted; }
  SensorFault fault(Eigen::Index sensor) const { return sensors_[sensor].fault; }
  double last_reading_K(Eigen::Index sensor) const { return sensors_[sensor].last_reading; }
  /// What the last reading should have been, with what the sensor usually differs by.
  double last_expected_K(Eigen::Index sensor) const { return sensors_[sensor].last_expected + sensors_[sensor].usual; }

private:
  struct Sample {
    double time, difference, reading;
    bool far;
  };
  /// The expectation of a sensor at one row.
  struct Row {
    double time, expected;
    double others;  ///< what sensors differ by from what is expected
    double unsure_K_s;
    bool inputs_leapt, explained;
  };
  struct Judged {
    const Row& row;
    double deviation, reading;
    double interval;    ///< s, since the reading before
    double difference;  ///< from what is expected and usual
    double step;        ///< of what is expected, since the reading before
    double unsure, unknown;
  };
  struct Sensor {
    SensorFault fault = SensorFault::none;
    bool trusted = true, known = false, leapt = false,
         from_start = false;  ///< from_start: far off at its first reading
    double seen_at = 0, last_reading = 0;
    double usual = 0;  ///< slow part of reading - expected; stands after a leap
    double last_difference = 0, last_expected = 0, last_unknown = 0;
    double expected_memory = 0;                ///< slow part of the expected reading
    double same_value = 0, same_expected = 0;  ///< of the present run of equal readings
    double same_unsure = 0, same_learnt = 0;   ///< K, of what the expected reading moved since
    int same_count = 0;
    bool held = false;  ///< the present run was found stuck
    double same_since = 0;
    double readings = 0, repeats = 0;  ///< in runs that have ended: how often readings repeat by chance
    double smallest_step = 0;          ///< of the reading's digits, where it has coarse ones
    std::array<double, 63> turns{};    ///< K, the last second differences of reading - expected while readings moved
    std::size_t turn_count = 0;
    double leapt_at = -1, leap = 0, agreed_since = -1, inputs_leapt_at = -1e18;  ///< s; K; s; s
    std::deque<Sample> recent;

    void judge(double deviation, double reading, const Row& row);

  private:
    void start(double time, double reading, double expected);
    void arrive(double deviation, double reading, const Row& row);
    bool stands_apart(const Judged& now);
    double scatter_K() const;
    bool is_stuck(const Judged& now);
    bool is_noisy(const Judged& now);
    void name_fault(const Judged& now, bool apart, bool stuck, bool noisy);
  };

  Eigen::VectorXd deviation_;
  std::vector<char> explained_;
  std::vector<Sensor> sensors_;
};

}  // namespace thermotwin::compensation
