//! `message!` writes a message struct and records what was written.
//!
//! The record ([`RosMessage::fields`](crate::RosMessage::fields),
//! [`constants`](crate::RosMessage::constants)) is made from the same tokens as the struct, so it is
//! right by construction; the tests hold it against the `.msg` file.

/// Defines a message. The last line names the function that checks its meaning.
macro_rules! message {
    (
        $(#[$doc:meta])*
        $package:literal / $name:ident
        $( constants { $( $(#[$const_doc:meta])* const $constant:ident : $const_type:ty = $value:expr; )* } )?
        fields { $( $(#[$field_doc:meta])* $field:ident : $field_type:ty, )* }
        ros name $ros_name:literal, meaning $meaning:expr
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
        pub struct $name {
            $( $(#[$field_doc])* pub $field: $field_type, )*
        }

        impl $name {
            $( $( $(#[$const_doc])* pub const $constant: $const_type = $value; )* )?
        }

        impl $crate::RosField for $name {
            fn ros_type() -> String {
                // A message of the same package is named without it.
                if $package == $crate::PACKAGE { $ros_name.to_owned() } else { concat!($package, "/", $ros_name).to_owned() }
            }
            fn check_bounds(&self, path: &str) -> Result<(), $crate::Invalid> {
                $crate::RosMessage::bounds(self, path)
            }
        }

        impl $crate::RosMessage for $name {
            const PACKAGE: &'static str = $package;
            const NAME: &'static str = $ros_name;

            fn fields() -> Vec<$crate::Field> {
                vec![ $( $crate::Field {
                    ros_type: <$field_type as $crate::RosField>::ros_type(),
                    name: stringify!($field),
                } ),* ]
            }

            fn constants() -> Vec<$crate::Constant> {
                vec![ $( $( $crate::Constant {
                    ros_type: <$const_type as $crate::RosField>::ros_type(),
                    name: stringify!($constant),
                    value: Self::$constant.to_string(),
                } ),* )? ]
            }

            fn bounds(&self, path: &str) -> Result<(), $crate::Invalid> {
                $( $crate::RosField::check_bounds(&self.$field, &format!("{path}.{}", stringify!($field)))?; )*
                Ok(())
            }

            fn validate(&self) -> Result<(), $crate::Invalid> {
                $crate::RosMessage::bounds(self, $ros_name)?;
                let meaning: fn(&Self) -> Result<(), $crate::Invalid> = $meaning;
                meaning(self)
            }
        }
    };
}

/// Defines a service of two messages.
macro_rules! service {
    ($(#[$doc:meta])* $package:literal / $name:ident = $request:ident -> $response:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy)]
        pub struct $name;

        impl $crate::RosService for $name {
            const PACKAGE: &'static str = $package;
            const NAME: &'static str = stringify!($name);
            type Request = $request;
            type Response = $response;
        }
    };
}

pub(crate) use {message, service};
