mod accelerometer;
mod buses;
mod dictionary;
mod inputs;
mod line;
mod outputs;
mod steps;
mod wire;
