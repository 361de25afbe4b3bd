// ROS 2 node: takes the raw gauges from the topic "raw", and publishes the load as WrenchStamped on "wrench" and the status of
// each sample on "status".
//
// Guarantees: each published load is computed from the message that has just arrived. A message that is rejected, or that has
// the wrong number of values, publishes no load. An axis that the calibration does not have is NaN.
#include <{{ name }}.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>
#include <std_msgs/msg/u_int8.hpp>

using geometry_msgs::msg::WrenchStamped;
using std_msgs::msg::Float64MultiArray;
using std_msgs::msg::UInt8;

class LoadNode : public rclcpp::Node {
public:
    LoadNode() : Node("{{ name }}"), mean_({{ n_inputs }}, 0.0)
    {
        frame_id_ = declare_parameter<std::string>("frame_id", "{{ name }}");
        // The first messages come from the unloaded sensor; 0 for no tare.
        n_tare_ = declare_parameter<int>("tare_samples", {{ 200 if tared else 0 }});
        wrench_ = create_publisher<WrenchStamped>("wrench", rclcpp::SensorDataQoS());
        status_ = create_publisher<UInt8>("status", rclcpp::SensorDataQoS());
        raw_ = create_subscription<Float64MultiArray>("raw", rclcpp::SensorDataQoS(),
                                                      [this](const Float64MultiArray &raw) { take(raw.data); });
    }

private:
    /* Values: {{ gauges }}{{ ', then ' ~ auxiliary if auxiliary }} */
    void take(const std::vector<double> &values)
    {
        const rclcpp::Time time = now();
        if (values.size() != {{ n_inputs }}) {
            RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), 1000, "%zu values instead of {{ n_inputs }}", values.size());
            return;
        }
        if (tared_ < n_tare_)
            return tare(values);
        const auto status = estimator_.update(time.seconds(), values.data(){{ ', values.data() + ' ~ n_gauges if auxiliary }});
        UInt8 flags;
        flags.data = static_cast<uint8_t>(status);
        status_->publish(flags);
        if ({{ name }}_estimator::is_rejected(status)) {
            RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), 1000, "rejected, status %d", static_cast<int>(status));
            return;
        }
        WrenchStamped load;
        load.header.stamp = time;
        load.header.frame_id = frame_id_;
{% for field, at in wrench %}
        load.wrench.{{ field }} = {{ 'estimator_.load()[' ~ at ~ ']' if at is not none else 'NAN' }};
{% endfor %}
        wrench_->publish(load);
    }

    void tare(const std::vector<double> &values)
    {
        for (const double value : values)
            if (!std::isfinite(value))
                return;
        for (size_t at = 0; at < values.size(); at++)
            mean_[at] += values[at] / n_tare_;
        if (++tared_ == n_tare_)
            estimator_.tare(mean_.data());
    }

    {{ name }}_estimator estimator_;
    std::vector<double> mean_;
    std::string frame_id_;
    int n_tare_ = 0, tared_ = 0;
    rclcpp::Publisher<WrenchStamped>::SharedPtr wrench_;
    rclcpp::Publisher<UInt8>::SharedPtr status_;
    rclcpp::Subscription<Float64MultiArray>::SharedPtr raw_;
};

int main(int argc, char **argv)
{
    rclcpp::init(argc, argv);
    rclcpp::spin(std::make_shared<LoadNode>());
    rclcpp::shutdown();
}
