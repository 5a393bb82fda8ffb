"""The surfaces that makeup lies on: lips, the skin around the eyes, the whole face."""
