mod bench;
mod dictionary;
mod inputs;
mod line;
mod outputs;
mod steps;
mod wire;
